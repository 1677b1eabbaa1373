// Importance sampling of a tabulated BRDF through its half-vector cells (render/materials/brdf_tables.h). Common subset of GLSL
// and C++ with GLM. Needs merl.glsl, and two functions that the includer defines before:
//   vec2 fetch_theta_cell(int elevation, int k)         (t_begin, t_end), t = 1 - cos(theta_h)
//   vec2 fetch_phi_cell(int elevation, int k, int p)    (phi_begin, phi_end) in [0, pi]
const int kBrdfElevations = 32;
const int kBrdfThetaCells = 96;
const int kBrdfPhiCells = 16;

// Probability of theta cell k: 32 cells of 1/64, then 64 cells, eight for each halving of the remaining probability; the last one has the
// rest. The sum is 1.
float theta_cell_mass(int k) {
  float tail = 0.5f * exp2(float(32 - k) * 0.125f);
  float mass = k < 32 ? 0.015625f : tail * 0.0829959568f;  // 1 - 2^(-1/8)
  return k == 95 ? tail : mass;
}

// The theta cell for a uniform number, and the position inside it (in [0, 1]).
struct ThetaCellChoice {
  int k;
  float position;
};

ThetaCellChoice theta_cell_of(float u) {
  ThetaCellChoice choice;
  float survival = max(2.0f - 2.0f * u, 1e-7f);  // 1 at the start of the tail
  float octave_cell = clamp(floor(-8.0f * log2(survival)), 0.0f, 63.0f);
  float begin = exp2(-0.125f * octave_cell);
  float width = octave_cell < 62.5f ? begin * 0.0829959568f : begin;
  float scaled = 64.0f * u;
  bool equal_part = u < 0.5f;
  choice.k = equal_part ? int(scaled) : 32 + int(octave_cell);
  choice.position = equal_part ? scaled - floor(scaled) : clamp((begin - survival) / width, 0.0f, 1.0f);
  return choice;
}

// Row of the tables nearest to a view direction.
int brdf_elevation(vec3 wo) {
  float theta = merl_atan(sqrt(wo.x * wo.x + wo.y * wo.y), max(wo.z, 0.0f));
  return min(int(theta * 20.37183272f), kBrdfElevations - 1);  // 32 / (pi / 2)
}

// A sampled direction to the light and its density over solid angle. pdf = 0: below the horizon; contributes nothing, but is counted.
struct BrdfSample {
  vec3 wi;
  float pdf;  // 1/sr
};

// Density over solid angle of h, 1/sr. Half, because the cells cover one side of the plane of view and normal.
float half_vector_density(int k, vec2 theta_cell, vec2 phi_cell) {
  return theta_cell_mass(k) / (2.0f * float(kBrdfPhiCells) * (theta_cell.y - theta_cell.x) * (phi_cell.y - phi_cell.x));
}

// The cell of half vectors for a pair of uniform numbers: u.x determines theta_h, u.y the side and phi_h.
struct BrdfCellChoice {
  ThetaCellChoice theta;
  int p;               // phi cell
  float phi_position;  // inside it, in [0, 1]
  float side;          // of the plane of view and normal, 1 or -1
};

BrdfCellChoice brdf_cell_of(vec2 u) {
  BrdfCellChoice choice;
  choice.theta = theta_cell_of(u.x);
  choice.side = u.y < 0.5f ? 1.0f : -1.0f;
  float along = u.y < 0.5f ? 2.0f * u.y : 2.0f * u.y - 1.0f;
  float scaled = float(kBrdfPhiCells) * along;
  choice.p = min(int(scaled), kBrdfPhiCells - 1);
  choice.phi_position = scaled - float(choice.p);
  return choice;
}

// The sample for a choice of cells and their borders, which the caller has fetched.
BrdfSample brdf_sample_in_cell(vec3 wo, BrdfCellChoice choice, vec2 theta_cell, vec2 phi_cell) {
  float t = theta_cell.x + choice.theta.position * (theta_cell.y - theta_cell.x);
  float phi = phi_cell.x + choice.phi_position * (phi_cell.y - phi_cell.x);
  // 1 - cos keeps small angles: sin^2 = t (2 - t).
  float sin_theta = sqrt(t * (2.0f - t));
  float along_view = sin_theta * cos(phi);
  float across_view = choice.side * sin_theta * sin(phi);
  float length_xy = sqrt(wo.x * wo.x + wo.y * wo.y);
  float cos_azimuth = length_xy > 0.0f ? wo.x / length_xy : 1.0f;
  float sin_azimuth = length_xy > 0.0f ? wo.y / length_xy : 0.0f;
  vec3 h = vec3(along_view * cos_azimuth - across_view * sin_azimuth,
                along_view * sin_azimuth + across_view * cos_azimuth, 1.0f - t);
  float projection = dot(wo, h);
  BrdfSample result;
  result.wi = (2.0f * projection) * h - wo;
  bool above = projection > 0.0f && result.wi.z > 0.0f;
  result.pdf = above ? half_vector_density(choice.theta.k, theta_cell, phi_cell) / (4.0f * projection) : 0.0f;
  return result;
}

BrdfSample sample_brdf(vec3 wo, vec2 u) {
  int elevation = brdf_elevation(wo);
  BrdfCellChoice choice = brdf_cell_of(u);
  vec2 theta_cell = fetch_theta_cell(elevation, choice.theta.k);
  return brdf_sample_in_cell(wo, choice, theta_cell, fetch_phi_cell(elevation, choice.theta.k, choice.p));
}

// Position of the half vector of two directions among the cells of wo: t = 1 - cos(theta_h); phi_h from the plane of view
// and normal, in [0, pi]; the length of wi + wo.
struct HalfVectorPosition {
  float t;
  float phi;
  float length_sum;
};

HalfVectorPosition half_vector_position(vec3 wo, vec3 wi) {
  HalfVectorPosition place;
  vec3 sum = wi + wo;
  place.length_sum = sqrt(dot(sum, sum));
  float xy = sum.x * sum.x + sum.y * sum.y;
  // 1 - z / |H| without cancellation.
  place.t = xy / max(place.length_sum * (place.length_sum + sum.z), 1e-30f);
  float c = sum.x * wo.x + sum.y * wo.y;
  float s = abs(sum.x * wo.y - sum.y * wo.x);
  place.phi = c < 0.0f ? 3.1415926536f - merl_atan(s, -c) : merl_atan(s, c);
  return place;
}

// Density over solid angle (1/sr) of wi where its half vector lies in theta cell k; 0 below the horizon.
float density_in_cell(vec3 wo, vec3 wi, HalfVectorPosition place, int k, vec2 theta_cell, vec2 phi_cell) {
  float density = half_vector_density(k, theta_cell, phi_cell);
  // wo . h = |H| / 2.
  return wi.z > 0.0f && wo.z > 0.0f && place.length_sum > 0.0f ? density / (2.0f * place.length_sum) : 0.0f;
}

// Density over solid angle (1/sr) with which sample_brdf(wo, .) gives wi; 0 below the horizon. Searches: 7 + 4 fetches.
float brdf_sample_pdf(vec3 wo, vec3 wi) {
  HalfVectorPosition place = half_vector_position(wo, wi);
  int elevation = brdf_elevation(wo);
  int k = 0;
  for (int i = 64; i > 0; i /= 2) {
    int next = k + i;
    k = next < kBrdfThetaCells && fetch_theta_cell(elevation, min(next, kBrdfThetaCells - 1)).x <= place.t ? next : k;
  }
  int p = 0;
  for (int i = kBrdfPhiCells / 2; i > 0; i /= 2) {
    p = fetch_phi_cell(elevation, k, p + i).x <= place.phi ? p + i : p;
  }
  return density_in_cell(wo, wi, place, k, fetch_theta_cell(elevation, k), fetch_phi_cell(elevation, k, p));
}
