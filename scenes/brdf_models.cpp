#include "scenes/brdf_models.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr double kHalfPi = 0.5 * std::numbers::pi;
/// Lower limit of the cosines in the masking terms: the tabulated lobe of a mirror grows like 1 / cos^2 towards the
/// horizon, where linear interpolation between bins of one degree would reflect more than the incident energy.
constexpr double kLeastCosine = 0.035;
constexpr int kHalfPhiD = kPhiDCount / 2;

double square(double x) { return x * x; }

double ggx(double tan_squared, double alpha) {
  const double a2 = alpha * alpha;
  return a2 * square(1.0 + tan_squared) / (std::numbers::pi * square(a2 + tan_squared));
}

/// Anisotropic GGX averaged over the azimuth of the brushing. Source: Heitz 2014, Eq. 85.
double brushed_ggx(double tan_squared, double along, double across) {
  constexpr int kAngles = 64;
  double sum = 0.0;
  for (int i = 0; i < kAngles; ++i) {
    const double phi = kHalfPi * (i + 0.5) / kAngles;
    const double e = tan_squared * (square(std::cos(phi) / along) + square(std::sin(phi) / across));
    sum += square(1.0 + tan_squared) / (std::numbers::pi * along * across * square(1.0 + e));
  }
  return sum / kAngles;
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

/// SIMD lanes: a row of constant theta_h and theta_d, phi_d in [0, pi / 2], padded to whole vector registers.
constexpr int kLanes = 96;
using Lanes = Eigen::Array<float, kLanes, 1>;

/// Values over an interval, with linear interpolation.
template <std::size_t kCount>
struct Curve {
  std::array<glm::vec3, kCount> values{};
  glm::vec3 operator()(float unit) const {
    const float x = std::clamp(unit, 0.0f, 1.0f) * static_cast<float>(kCount - 1);
    const auto i = std::min(static_cast<std::size_t>(x), kCount - 2);
    const float f = x - static_cast<float>(i);
    return values[i] * (1.0f - f) + values[i + 1] * f;
  }
};

/// The part of a model that does not depend on the angles.
struct Prepared {
  const LayeredModel& model;
  bool coated;
  float index;
  glm::vec3 diffuse{};  ///< BRDF of the substrate seen from outside, without the coat's transmission
  Curve<kFresnelCount> reflectance;
  Curve<65> tint;  ///< over the mean path factor 1 / cos, from 1 to longest_path
  float longest_path;
  float oren_a, oren_b;

  explicit Prepared(const LayeredModel& m)
      : model(m), coated(m.coat_index > 0.0), index(coated ? static_cast<float>(m.coat_index) : 1.0f) {
    // Light that the coat reflects back down bounces again. Source: Saunderson 1942, Eq. 5; the internal diffuse
    // reflectance of the interface: Egan & Hilgeman 1973.
    const double n = coated ? m.coat_index : 1.0, inverse = 1.0 / n;
    const double internal = coated ? -1.440 * inverse * inverse + 0.710 * inverse + 0.668 + 0.0636 * n : 0.0;
    double covered = 0.0;
    for (const FacetLobe& lobe : m.flakes) covered += lobe.weight;
    const double open = 1.0 - std::min(covered, 1.0) * (1.0 - m.flake_transmission);
    diffuse = glm::vec3(m.diffuse * open / (std::numbers::pi * n * n * (1.0 - m.diffuse * internal)));
    for (std::size_t i = 0; i < m.flake_reflectance.size(); ++i) reflectance.values[i] = m.flake_reflectance[i];
    const double longest = coated ? 1.0 / std::sqrt(1.0 - inverse * inverse) : 4.0;
    longest_path = static_cast<float>(longest);
    for (std::size_t i = 0; i < tint.values.size(); ++i) {
      const double path = 1.0 + (longest - 1.0) * static_cast<double>(i) / static_cast<double>(tint.values.size() - 1);
      tint.values[i] = glm::vec3(glm::pow(m.flake_tint, glm::dvec3(path)));
    }
    const double s2 = square(m.diffuse_sigma_rad);
    oren_a = static_cast<float>(1.0 - 0.5 * s2 / (s2 + 0.33));
    oren_b = static_cast<float>(0.45 * s2 / (s2 + 0.09));
  }
};

/// The part that depends on theta_h alone.
struct HalfAngle {
  double cosine, sine, coat = 0.0, sheen = 0.0;
  std::vector<double> brushed;  ///< distribution of each brushed lobe, 0 for others
};

HalfAngle make_half_angle(const LayeredModel& model, double theta_h) {
  HalfAngle h{std::cos(theta_h), std::sin(theta_h), 0.0, 0.0, {}};
  const double tan_squared = square(h.sine / h.cosine);
  for (const FacetLobe& lobe : model.flakes) {
    h.brushed.push_back(lobe.alpha_across > 0.0 ? brushed_ggx(tan_squared, lobe.alpha, lobe.alpha_across) : 0.0);
  }
  if (model.coat_index > 0.0) h.coat = ggx(tan_squared, model.coat_alpha) * model.coat_share;
  const double exponent = 1.0 / model.sheen_roughness;
  h.sheen = (2.0 + exponent) * std::pow(h.sine, exponent) / (2.0 * std::numbers::pi);
  return h;
}

/// Uncorrelated Smith masking over 4 cos cos, as a product of one factor per direction.
Lanes masking_factor(const Lanes& cosine, double alpha) {
  const auto a2 = static_cast<float>(alpha * alpha);
  return (cosine + (a2 + (1.0f - a2) * cosine.square()).sqrt()).inverse();
}

/// Cosine after refraction at a smooth interface, and its transmittance (1 - Fresnel).
Lanes refracted_cosine(const Lanes& cosine, float index) {
  return (1.0f - (1.0f - cosine.square()) / (index * index)).sqrt();
}
Lanes transmission(const Lanes& outside, const Lanes& inside, float index) {
  const Lanes s = (outside - index * inside) / (outside + index * inside);
  const Lanes p = (inside - index * outside) / (inside + index * outside);
  return 1.0f - 0.5f * (s.square() + p.square());
}

/// Flakes seen through the coat (or bare): both directions are refracted, then the facet model is evaluated about their
/// half vector.
void add_flakes(const Prepared& p, const HalfAngle& h, double cos_d, const Lanes& in_i, const Lanes& in_o,
                glm::vec3* row) {
  const auto h_xy = static_cast<float>(2.0 * cos_d * h.sine / static_cast<double>(p.index));  // |(wi + wo)_xy| inside
  const Lanes h_z = in_i + in_o;
  const Lanes tan_squared = (h_xy / h_z).square();
  const Lanes inner_cos_d = 0.5f * (h_xy * h_xy + h_z.square()).sqrt();
  Lanes shape = Lanes::Zero();
  for (std::size_t l = 0; l < p.model.flakes.size(); ++l) {
    const FacetLobe& lobe = p.model.flakes[l];
    const bool brushed = lobe.alpha_across > 0.0;
    const double alpha = brushed ? std::sqrt(lobe.alpha * lobe.alpha_across) : lobe.alpha;
    const auto a2 = static_cast<float>(alpha * alpha);
    const auto scale = static_cast<float>(lobe.weight / square(static_cast<double>(p.index)));
    const Lanes masked = scale * masking_factor(in_i, alpha) * masking_factor(in_o, alpha);
    if (brushed) {
      shape += static_cast<float>(h.brushed[l]) * masked;
    } else {
      shape +=
          a2 / static_cast<float>(std::numbers::pi) * ((1.0f + tan_squared) / (a2 + tan_squared)).square() * masked;
    }
  }
  const Lanes path = (0.5f * (in_i.inverse() + in_o.inverse()) - 1.0f) / (p.longest_path - 1.0f);
  for (int i = 0; i < kHalfPhiD; ++i) row[i] += p.reflectance(inner_cos_d[i]) * p.tint(path[i]) * shape[i];
}

/// Oren & Nayar's shape factor; symmetric in both directions. sin sin cos(phi) = wi . wo - cos cos.
Lanes oren_nayar(const Prepared& p, double cos_d, const Lanes& cos_i, const Lanes& cos_o) {
  const Lanes dot_xy = static_cast<float>(2.0 * square(cos_d) - 1.0) - cos_i * cos_o;
  return p.oren_a + p.oren_b * dot_xy.max(0.0f) / cos_i.max(cos_o);
}

/// The row of one theta_h and theta_d, phi_d from 0 to pi / 2.
void evaluate_row(const Prepared& p, const HalfAngle& h, double cos_d, double sin_d, const Lanes& cos_phi,
                  glm::vec3* row) {
  const LayeredModel& m = p.model;
  const auto middle = static_cast<float>(h.cosine * cos_d);
  const Lanes across = static_cast<float>(h.sine * sin_d) * cos_phi;
  const Lanes cos_i = (middle - across).max(static_cast<float>(kLeastCosine)).min(1.0f);
  const Lanes cos_o = (middle + across).max(static_cast<float>(kLeastCosine)).min(1.0f);
  Lanes transmitted = Lanes::Ones(), reflected = Lanes::Zero(), in_i = cos_i, in_o = cos_o;
  if (p.coated) {
    in_i = refracted_cosine(cos_i, p.index);
    in_o = refracted_cosine(cos_o, p.index);
    transmitted = transmission(cos_i, in_i, p.index) * transmission(cos_o, in_o, p.index);
    const auto lobe = static_cast<float>(h.coat * fresnel_dielectric(cos_d, m.coat_index));
    reflected = lobe * masking_factor(cos_i, m.coat_alpha) * masking_factor(cos_o, m.coat_alpha);
  }
  const Lanes diffuse = m.diffuse_sigma_rad > 0.0 ? oren_nayar(p, cos_d, cos_i, cos_o) : Lanes(Lanes::Ones());
  for (int i = 0; i < kHalfPhiD; ++i) row[i] = p.diffuse * diffuse[i];
  if (!m.flakes.empty()) add_flakes(p, h, cos_d, in_i, in_o, row);
  for (int i = 0; i < kHalfPhiD; ++i) row[i] = row[i] * transmitted[i] + glm::vec3(reflected[i]);
  if (m.sheen.x + m.sheen.y + m.sheen.z > 0.0) {
    const Lanes fibres = static_cast<float>(0.25 * h.sheen) / (cos_i + cos_o - cos_i * cos_o);
    for (int i = 0; i < kHalfPhiD; ++i) row[i] += glm::vec3(m.sheen) * fibres[i];
  }
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
  // White is equal-energy light: every channel is divided by that of a perfect reflector.
  const glm::dvec3 white_rgb = rec709_from_xyz(white);
  for (int i = 0; i < kFresnelCount; ++i) {
    const double c = static_cast<double>(i) / (kFresnelCount - 1);
    const double cos_film =
        std::sqrt(std::max(0.0, 1.0 - (1.0 - c * c) * square(film.outside_index / film.film_index)));
    glm::dvec3 xyz(0.0);
    for (int w = 0; w < kWavelengths; ++w) {
      const double lambda = kFirst + w * kStep;
      const double phase = 4.0 * std::numbers::pi * film.film_index * film.thickness_nm * cos_film / lambda;
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
  Lanes cos_phi;
  for (int i = 0; i < kLanes; ++i) cos_phi[i] = static_cast<float>(std::cos((i + 0.5) / kPhiDCount * std::numbers::pi));
  parallel_for(0, kThetaHCount, [&](int bin) {
    const HalfAngle h = make_half_angle(model, square((bin + 0.5) / kThetaHCount) * kHalfPi);
    for (int d = 0; d < kThetaDCount; ++d) {
      const double theta_d = (d + 0.5) / kThetaDCount * kHalfPi;
      glm::vec3* row = rgb.data() + (bin * kThetaDCount + d) * kPhiDCount;
      evaluate_row(prepared, h, std::cos(theta_d), std::sin(theta_d), cos_phi, row);
      // The entries at phi_d and pi - phi_d exchange the two directions.
      for (int p = 0; p < kHalfPhiD; ++p) row[kPhiDCount - 1 - p] = row[p];
    }
  });
  return rgb;
}

}  // namespace maquette
