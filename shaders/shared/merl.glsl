// Coordinates of the MERL table for a pair of directions. Common subset of GLSL and C++ with GLM.
// Directions: unit, local frame, z = normal. Source: Rusinkiewicz 1998, "A New Change of Variables for Efficient BRDF
// Representation"; bins: Matusik et al. 2003.
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

const int kMerlThetaD = 90;
const int kMerlPhiD = 180;

// atan(y / x) for y >= 0, x >= 0; 0 for (0, 0). Largest error 1.7e-6 rad, relative 2.3e-5 (minimax over [0, 1], our own fit).
MAQUETTE_FN float merl_atan(float y, float x) {
  float largest = max(max(x, y), 1e-30f);
  float r = min(x, y) / largest;
  float s = r * r;
  float a = r * (0.9999772195f +
                 s * (-0.3326228326f +
                      s * (0.1935403927f + s * (-0.1164265053f + s * (0.0526473636f + s * -0.0117191367f)))));
  return y > x ? 1.5707963268f - a : a;
}

// (theta_h, theta_d, phi_d) as continuous bins: integer k is the centre of bin k, so the values run from -0.5 to count - 0.5.
// phi_d is folded into [0, pi) by reciprocity and is periodic.
//
// With the unnormalised H = wi + wo and D = wi - wo (always perpendicular), tan(theta_h) = |Hxy| / Hz, tan(theta_d) = |D| / |H|,
// tan(phi_d) = (Dy Hx - Dx Hy) / (-Dz |H|). No arc cosine: small angles keep their relative accuracy.
MAQUETTE_FN vec3 merl_coordinates(vec3 wi, vec3 wo) {
  vec3 half_vector = wi + wo;
  vec3 difference = wi - wo;
  float xy = half_vector.x * half_vector.x + half_vector.y * half_vector.y;
  float half_length = sqrt(xy + half_vector.z * half_vector.z);
  float theta_h = merl_atan(sqrt(xy), half_vector.z);
  float theta_d = merl_atan(sqrt(dot(difference, difference)), half_length);
  float s = difference.y * half_vector.x - difference.x * half_vector.y;
  float c = -difference.z * half_length;
  float phi = merl_atan(abs(s), abs(c));
  // Same sign of s and c: first quadrant after folding by pi; otherwise second.
  float phi_d = s * c < 0.0f ? 3.1415926536f - phi : phi;
  return vec3(sqrt(theta_h * 5156.620156f) - 0.5f,  // 90 sqrt(theta_h / (pi / 2))
              theta_d * 57.29577951f - 0.5f, phi_d * 57.29577951f - 0.5f);
}

// The eight entries around a coordinate and where it lies between them.
struct MerlCell {
  ivec3 lower;    // (theta_h, theta_d, phi_d) of the lower corner
  ivec3 upper;    // of the upper corner; phi_d wraps, the others clamp
  vec3 fraction;  // in [0, 1], weight of the upper corner per axis
};

MAQUETTE_FN MerlCell merl_cell(vec3 coordinates) {
  float theta_h = clamp(coordinates.x, 0.0f, 89.0f);
  float theta_d = clamp(coordinates.y, 0.0f, 89.0f);
  float phi_d = coordinates.z < 0.0f ? coordinates.z + 180.0f : coordinates.z;
  vec3 floored = vec3(min(floor(theta_h), 88.0f), min(floor(theta_d), 88.0f), min(floor(phi_d), 179.0f));
  MerlCell cell;
  cell.lower = ivec3(floored);
  cell.upper = cell.lower + ivec3(1, 1, 1);
  cell.upper.z = cell.upper.z == kMerlPhiD ? 0 : cell.upper.z;
  cell.fraction = vec3(theta_h, theta_d, phi_d) - floored;
  return cell;
}

MAQUETTE_FN int merl_index(int theta_h, int theta_d, int phi_d) {
  return phi_d + kMerlPhiD * (theta_d + kMerlThetaD * theta_h);
}
