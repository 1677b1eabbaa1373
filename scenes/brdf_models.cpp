#include "scenes/brdf_models.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

namespace maquette {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kHalfPi = 0.5 * kPi;
/// Cosines below this are held in the masking terms: the tabulated lobe of a mirror grows like 1 / cos^2 towards the
/// horizon, where linear interpolation between bins of one degree would exceed the energy that came in.
constexpr double kLeastCosine = 0.035;
constexpr int kHalfPhiD = kPhiDCount / 2;

double square(double x) { return x * x; }

double ggx(double tan_squared, double alpha) {
  const double a2 = alpha * alpha;
  return a2 * square(1.0 + tan_squared) / (kPi * square(a2 + tan_squared));
}

/// Uncorrelated Smith masking over 4 cos cos, as a product of one factor per direction.
double masking_factor(double cosine, double alpha) {
  const double c = std::max(cosine, kLeastCosine), a2 = alpha * alpha;
  return 1.0 / (c + std::sqrt(a2 + (1.0 - a2) * c * c));
}

/// Anisotropic GGX averaged over the azimuth of the brushing. Source: Heitz 2014, Eq. 85.
double brushed_ggx(double tan_squared, double along, double across) {
  constexpr int kAngles = 64;
  double sum = 0.0;
  for (int i = 0; i < kAngles; ++i) {
    const double phi = kHalfPi * (i + 0.5) / kAngles;
    const double e = tan_squared * (square(std::cos(phi) / along) + square(std::sin(phi) / across));
    sum += square(1.0 + tan_squared) / (kPi * along * across * square(1.0 + e));
  }
  return sum / kAngles;
}

glm::vec3 look_up(const FresnelCurve& curve, double cosine) {
  const float x = static_cast<float>(std::clamp(cosine, 0.0, 1.0)) * (kFresnelCount - 1);
  const auto i = std::min(static_cast<std::size_t>(x), std::size_t{kFresnelCount - 2});
  const float f = x - static_cast<float>(i);
  return curve[i] * (1.0f - f) + curve[i + 1] * f;
}

/// One lobe of CIE 1931 matching functions. Source: Wyman, Sloan & Shirley 2013, Sec. 2.2 (multi-lobe fit).
double gaussian(double lambda, double mean, double below, double above) {
  return std::exp(-0.5 * square((lambda - mean) / (lambda < mean ? below : above)));
}
glm::dvec3 matching_functions(double lambda) {
  return {1.056 * gaussian(lambda, 599.8, 37.9, 31.0) + 0.362 * gaussian(lambda, 442.0, 16.0, 26.7) -
              0.065 * gaussian(lambda, 501.1, 20.4, 26.2),
          0.821 * gaussian(lambda, 568.8, 46.9, 40.5) + 0.286 * gaussian(lambda, 530.9, 16.3, 31.1),
          1.217 * gaussian(lambda, 437.0, 11.8, 36.0) + 0.681 * gaussian(lambda, 459.0, 26.0, 13.8)};
}
glm::dvec3 rec709_from_xyz(const glm::dvec3& xyz) {
  return {3.2404542 * xyz.x - 1.5371385 * xyz.y - 0.4985314 * xyz.z,
          -0.9692660 * xyz.x + 1.8760108 * xyz.y + 0.0415560 * xyz.z,
          0.0556434 * xyz.x - 0.2040259 * xyz.y + 1.0572252 * xyz.z};
}

/// Everything of a model that depends on one angle alone, so that the inner loop is short.
struct Prepared {
  const LayeredModel& model;
  bool coated;
  double index;
  double diffuse_scale[3];
  std::array<glm::vec3, 257> tint;  ///< over the path length factor, 1 to kLongestPath
  double longest_path;
  double oren_a, oren_b;

  explicit Prepared(const LayeredModel& m) : model(m), coated(m.coat_index > 0.0), index(coated ? m.coat_index : 1.0) {
    // Light that the coat sends back down bounces again. Source: Saunderson 1942, Eq. 5; the internal diffuse
    // reflectance of the interface: Egan & Hilgeman 1973.
    const double inverse = 1.0 / index;
    const double outside = -1.440 * inverse * inverse + 0.710 * inverse + 0.668 + 0.0636 * index;
    const double internal = coated ? outside : 0.0;
    for (int c = 0; c < 3; ++c) {
      diffuse_scale[c] = model.diffuse[c] / (kPi * index * index * (1.0 - model.diffuse[c] * internal));
    }
    longest_path = coated ? 1.0 / std::sqrt(1.0 - 1.0 / (index * index)) : 4.0;
    for (std::size_t i = 0; i < tint.size(); ++i) {
      const double path = 1.0 + (longest_path - 1.0) * static_cast<double>(i) / static_cast<double>(tint.size() - 1);
      tint[i] = glm::vec3(glm::pow(model.flake_tint, glm::dvec3(path)));
    }
    const double s2 = square(model.diffuse_sigma_rad);
    oren_a = 1.0 - 0.5 * s2 / (s2 + 0.33);
    oren_b = 0.45 * s2 / (s2 + 0.09);
  }

  glm::vec3 tint_at(double path) const {
    const double x = std::clamp((path - 1.0) / (longest_path - 1.0), 0.0, 1.0) * static_cast<double>(tint.size() - 1);
    return tint[static_cast<std::size_t>(x + 0.5)];
  }
};

/// One pair of directions: `h` the half vector's angle, cosines of both to the normal, of both to h.
struct Geometry {
  double cos_h, sin_h, cos_d, cos_i, cos_o;
  std::vector<double> brushed;  ///< distribution of each brushed lobe at this theta_h, 0 for others
  double sheen = 0.0;           ///< distribution of fibres at this theta_h
};

/// Oren & Nayar's shape factor; symmetric in both directions.
double oren_nayar(const Prepared& p, const Geometry& g) {
  if (p.model.diffuse_sigma_rad <= 0.0) return 1.0;
  const double sin_i = std::sqrt(1.0 - square(g.cos_i)), sin_o = std::sqrt(1.0 - square(g.cos_o));
  const double dot_xy = 2.0 * square(g.cos_d) - 1.0 - g.cos_i * g.cos_o;  // sin_i sin_o cos(phi)
  const double largest_cos = std::max(std::max(g.cos_i, g.cos_o), 1e-3);
  const double product = sin_i * sin_o;
  return p.oren_a + (dot_xy > 0.0 && product > 0.0 ? p.oren_b * dot_xy / largest_cos : 0.0);
}

/// Flakes seen through the coat (or bare): both directions refracted, then the facet model about their half vector.
glm::vec3 flake_term(const Prepared& p, const Geometry& g, double cos_i, double cos_o) {
  const LayeredModel& m = p.model;
  const double h_xy = 2.0 * g.cos_d * g.sin_h / p.index;  // |(wi + wo)_xy| inside
  const double h_z = cos_i + cos_o;
  const double tan_squared = square(h_xy / h_z);
  const double cos_d = std::min(0.5 * std::sqrt(square(h_xy) + square(h_z)), 1.0);
  glm::vec3 sum(0.0f);
  for (std::size_t l = 0; l < m.flakes.size(); ++l) {
    const FacetLobe& lobe = m.flakes[l];
    const bool brushed = lobe.alpha_across > 0.0;
    const double distribution = brushed ? g.brushed[l] : ggx(tan_squared, lobe.alpha);
    const double alpha = brushed ? std::sqrt(lobe.alpha * lobe.alpha_across) : lobe.alpha;
    const double shape = lobe.weight * distribution * masking_factor(cos_i, alpha) * masking_factor(cos_o, alpha);
    sum += look_up(lobe.reflectance, cos_d) * static_cast<float>(shape);
  }
  return sum * p.tint_at(0.5 * (1.0 / cos_i + 1.0 / cos_o)) / static_cast<float>(square(p.index));
}

double sheen_distribution(double sin_h, double roughness) {
  return (2.0 + 1.0 / roughness) * std::pow(sin_h, 1.0 / roughness) / (2.0 * kPi);
}

double sheen_term(const Geometry& g) {
  const double ci = std::max(g.cos_i, kLeastCosine), co = std::max(g.cos_o, kLeastCosine);
  return g.sheen / (4.0 * (ci + co - ci * co));
}

glm::vec3 evaluate(const Prepared& p, const Geometry& g, double coat_lobe) {
  const LayeredModel& m = p.model;
  double transmitted = 1.0, inside_i = std::max(g.cos_i, kLeastCosine), inside_o = std::max(g.cos_o, kLeastCosine);
  double reflected = 0.0;
  if (p.coated) {
    transmitted = (1.0 - fresnel_dielectric(inside_i, p.index)) * (1.0 - fresnel_dielectric(inside_o, p.index));
    inside_i = std::sqrt(1.0 - (1.0 - square(inside_i)) / square(p.index));
    inside_o = std::sqrt(1.0 - (1.0 - square(inside_o)) / square(p.index));
    reflected =
        m.coat_share * coat_lobe * masking_factor(g.cos_i, m.coat_alpha) * masking_factor(g.cos_o, m.coat_alpha);
  }
  double covered = 0.0;
  for (const FacetLobe& lobe : m.flakes) covered += lobe.weight;
  const double diffuse = oren_nayar(p, g) * (1.0 - std::min(covered, 1.0) * (1.0 - m.flake_transmission));
  glm::vec3 below(static_cast<float>(p.diffuse_scale[0] * diffuse), static_cast<float>(p.diffuse_scale[1] * diffuse),
                  static_cast<float>(p.diffuse_scale[2] * diffuse));
  if (!m.flakes.empty()) below += flake_term(p, g, inside_i, inside_o);
  glm::vec3 result = below * static_cast<float>(transmitted) + glm::vec3(static_cast<float>(reflected));
  if (m.sheen.x + m.sheen.y + m.sheen.z > 0.0) result += glm::vec3(m.sheen * sheen_term(g));
  return result;
}

}  // namespace

double fresnel_dielectric(double cos_theta, double eta) {
  const double c = std::clamp(std::abs(cos_theta), 0.0, 1.0);
  const double sin_t2 = (1.0 - c * c) / (eta * eta);
  if (sin_t2 >= 1.0) return 1.0;
  const double ct = std::sqrt(1.0 - sin_t2);
  return 0.5 * (square((c - eta * ct) / (c + eta * ct)) + square((ct - eta * c) / (ct + eta * c)));
}

double fresnel_conductor(double cos_theta, double eta, double k) {
  const double c = std::clamp(cos_theta, 0.0, 1.0), s2 = 1.0 - c * c;
  const std::complex<double> index(eta, k);
  const std::complex<double> ct = std::sqrt(1.0 - s2 / (index * index));
  const std::complex<double> rs = (c - index * ct) / (c + index * ct);
  const std::complex<double> rp = (index * c - ct) / (index * c + ct);
  return 0.5 * (std::norm(rs) + std::norm(rp));
}

FresnelCurve conductor_curve(const glm::dvec3& eta, const glm::dvec3& k, double outside) {
  FresnelCurve curve(kFresnelCount);
  for (int i = 0; i < kFresnelCount; ++i) {
    const double c = static_cast<double>(i) / (kFresnelCount - 1);
    for (int channel = 0; channel < 3; ++channel) {
      curve[static_cast<std::size_t>(i)][channel] =
          static_cast<float>(fresnel_conductor(c, eta[channel] / outside, k[channel] / outside));
    }
  }
  return curve;
}

FresnelCurve thin_film_curve(const ThinFilm& film) {
  constexpr double kFirst = 390.0, kStep = 10.0;
  constexpr int kWavelengths = 34;
  FresnelCurve curve(kFresnelCount);
  glm::dvec3 white(0.0);
  for (int w = 0; w < kWavelengths; ++w) white += matching_functions(kFirst + w * kStep);
  // Equal-energy light is white here: every channel is divided by what a perfect reflector gives.
  const glm::dvec3 white_rgb = rec709_from_xyz(white);
  for (int i = 0; i < kFresnelCount; ++i) {
    const double c = static_cast<double>(i) / (kFresnelCount - 1);
    const double cos_film =
        std::sqrt(std::max(0.0, 1.0 - (1.0 - c * c) * square(film.outside_index / film.film_index)));
    glm::dvec3 xyz(0.0);
    for (int w = 0; w < kWavelengths; ++w) {
      const double lambda = kFirst + w * kStep;
      const double phase = 4.0 * kPi * film.film_index * film.thickness_nm * cos_film / lambda;
      const double a = film.top_amplitude, b = film.bottom_amplitude, cos_phase = std::cos(phase);
      const double reflectance =
          (a * a + b * b + 2.0 * a * b * cos_phase) / (1.0 + a * a * b * b + 2.0 * a * b * cos_phase);
      xyz += matching_functions(lambda) * reflectance;
    }
    curve[static_cast<std::size_t>(i)] = glm::vec3(glm::clamp(rec709_from_xyz(xyz) / white_rgb, 0.0, 1.0));
  }
  return curve;
}

std::vector<glm::vec3> tabulate_model(const LayeredModel& model) {
  std::vector<glm::vec3> rgb(kBrdfEntryCount);
  const Prepared prepared(model);
  tbb::parallel_for(0, kThetaHCount, [&](int h) {
    Geometry g;
    const double theta_h = square((h + 0.5) / kThetaHCount) * kHalfPi;
    g.cos_h = std::cos(theta_h);
    g.sin_h = std::sin(theta_h);
    const double tan_squared = square(g.sin_h / g.cos_h);
    for (const FacetLobe& lobe : model.flakes) {
      g.brushed.push_back(lobe.alpha_across > 0.0 ? brushed_ggx(tan_squared, lobe.alpha, lobe.alpha_across) : 0.0);
    }
    g.sheen = sheen_distribution(g.sin_h, model.sheen_roughness);
    const double coat = prepared.coated ? ggx(tan_squared, model.coat_alpha) : 0.0;
    for (int d = 0; d < kThetaDCount; ++d) {
      const double theta_d = (d + 0.5) / kThetaDCount * kHalfPi;
      g.cos_d = std::cos(theta_d);
      const double sin_d = std::sin(theta_d);
      const double coat_lobe = prepared.coated ? coat * fresnel_dielectric(g.cos_d, prepared.index) : 0.0;
      glm::vec3* row = &rgb[static_cast<std::size_t>((h * kThetaDCount + d) * kPhiDCount)];
      for (int p = 0; p < kHalfPhiD; ++p) {
        const double across = g.sin_h * sin_d * std::cos((p + 0.5) / kPhiDCount * kPi);
        g.cos_i = std::clamp(g.cos_h * g.cos_d - across, 0.0, 1.0);
        g.cos_o = std::clamp(g.cos_h * g.cos_d + across, 0.0, 1.0);
        // phi_d and pi - phi_d exchange both directions.
        row[p] = row[kPhiDCount - 1 - p] = evaluate(prepared, g, coat_lobe);
      }
    }
  });
  return rgb;
}

}  // namespace maquette
