// The local bandwidth of a surface along any direction of the screen: from the change of position and normal over one pixel to the right and one
// down, through the operators of shared/bandwidth.glsl, to weights of interpolation along each direction.
// Source: Bagher et al. 2012, Sec. 4 (the operators; interpolation by an anisotropic Gaussian). Differs: any direction of the screen, by a quadratic
// form that agrees with the operators along both axes and both diagonals (docs/numerics/bandwidth.md, "How they are filled").
// Common subset of GLSL and C++ with GLM (render/math/shared_formulas.h).
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

/// Lengths of the changes of position and of the normal along both screen axes, and the cosines between them.
struct ScreenCurvature {
  vec2 step_m;
  vec2 turn;  // chords between unit normals
  float step_cosine;
  float normal_change_cosine;
};

/// 0 where one of them has no length.
MAQUETTE_FN float cosine_between(vec3 a, vec3 b) {
  float lengths = length(a) * length(b);
  return lengths > 0.0f ? clamp(dot(a, b) / lengths, -1.0f, 1.0f) : 0.0f;
}

/// Packed in four words: steps as floats (for scenes of 1e-6 m), changes of the normal as halves, cosines as snorm 16.
MAQUETTE_FN uvec4 pack_screen_curvature(vec3 step_x_m, vec3 step_y_m, vec3 turn_x, vec3 turn_y) {
  vec2 step_m = max(vec2(length(step_x_m), length(step_y_m)), vec2(1e-12f));
  vec2 turn = vec2(length(turn_x), length(turn_y));
  vec2 cosines = vec2(cosine_between(step_x_m / step_m.x, step_y_m / step_m.y), cosine_between(turn_x, turn_y));
  return uvec4(floatBitsToUint(step_m.x), floatBitsToUint(step_m.y), packHalf2x16(turn), packSnorm2x16(cosines));
}

MAQUETTE_FN ScreenCurvature unpack_screen_curvature(uvec4 packed_curvature) {
  vec2 cosines = unpackSnorm2x16(packed_curvature.w);
  ScreenCurvature b;
  b.step_m = vec2(uintBitsToFloat(packed_curvature.x), uintBitsToFloat(packed_curvature.y));
  b.turn = unpackHalf2x16(packed_curvature.z);
  b.step_cosine = cosines.x;
  b.normal_change_cosine = cosines.y;
  return b;
}

/// Length of the sum (sign 1) or the difference (-1) of two vectors with the given lengths.
MAQUETTE_FN float diagonal_length(vec2 lengths, float cosine, float sign) {
  return sqrt(max(dot(lengths, lengths) + 2.0f * sign * cosine * lengths.x * lengths.y, 0.0f));
}

/// Cycles of one pixel along x and along y, and the correlation c of the metric by which (a, b) pixels are
/// sqrt((a nu_x)^2 + 2 c a nu_x b nu_y + (b nu_y)^2) cycles. c follows from the bandwidths along both diagonals.
MAQUETTE_FN vec3 screen_bandwidth(ScreenCurvature bend, float nu_theta, float nu_surface, float pixel_angle) {
  float cycles[4];
  for (int k = 0; k < 4; ++k) {
    float sign = k == 2 ? 1.0f : -1.0f;
    float step_m = k == 0 ? bend.step_m.x : k == 1 ? bend.step_m.y : diagonal_length(bend.step_m, bend.step_cosine, sign);
    step_m = max(step_m, 1e-12f);
    float turn = k == 0 ? bend.turn.x : k == 1 ? bend.turn.y : diagonal_length(bend.turn, bend.normal_change_cosine, sign);
    float angle = k < 2 ? pixel_angle : 1.4142136f * pixel_angle;
    cycles[k] = bandwidth_one_bounce(nu_theta, turn / step_m, nu_surface, angle, step_m);
  }
  float correlation = (cycles[2] + cycles[3]) * (cycles[2] - cycles[3]) / max(4.0f * cycles[0] * cycles[1], 1e-20f);
  return vec3(cycles[0], cycles[1], clamp(correlation, -1.0f, 1.0f));
}

/// Lower limit of a squared step, relative to the sum of both axes'. Below it the error is mostly noise, which is larger when fewer points are averaged.
/// Chosen by the error of a rotated cylinder (docs/tried.md).
const float kLeastSquaredStep = 0.15f;

/// Weights of interpolation along x, y, (1, 1) and (1, -1): 1 / its squared error, which grows with the fourth power of the step in cycles between two
/// points, and with the eighth for a cubic. `bandwidth`: of screen_bandwidth.
MAQUETTE_FN vec4 axis_shares(vec3 bandwidth, bool cubic) {
  float x = bandwidth.x * bandwidth.x + 1e-8f, y = bandwidth.y * bandwidth.y + 1e-8f, sum = x + y;
  float cross = 2.0f * bandwidth.z * bandwidth.x * bandwidth.y;
  vec4 squared_step = max(vec4(x, y, sum + cross, sum - cross) / sum, vec4(kLeastSquaredStep));
  vec4 share = 1.0f / (squared_step * squared_step);
  return cubic ? share * share : share;
}
