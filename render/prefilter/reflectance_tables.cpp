#include "render/prefilter/reflectance_tables.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

#include "render/environment/prefilter.h"
#include "render/math/shared_formulas.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr int kSamples = 512;

/// Direction i of a spiral: `cosine` from the axis, golden angles in azimuth.
glm::dvec3 spiral(int i, double cosine) {
  const double phi = std::numbers::pi * (3.0 - std::sqrt(5.0)) * i,
               sine = std::sqrt(std::max(0.0, 1.0 - cosine * cosine));
  return {sine * std::cos(phi), sine * std::sin(phi), cosine};
}

glm::dvec3 view_at(double nv) { return {std::sqrt(1.0 - nv * nv), 0.0, nv}; }

double sheen_albedo(double nv, double roughness) {
  const glm::dvec3 wo = view_at(nv);
  const auto alpha = static_cast<float>(std::max(roughness * roughness, 1e-2));
  double sum = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    const glm::dvec3 wi = spiral(i, (i + 0.5) / kSamples), h = glm::normalize(wi + wo);
    sum += wi.z * static_cast<double>(shared::sheen_lobe(glm::vec3(h), glm::vec3(wi), glm::vec3(wo), alpha));
  }
  return 2.0 * std::numbers::pi * sum / kSamples;
}

double mean_schlick_weight(double nv) {
  const glm::dvec3 wo = view_at(nv);
  double sum = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    const glm::dvec3 wi = spiral(i, std::sqrt((i + 0.5) / kSamples)), h = glm::normalize(wi + wo);
    sum += std::pow(1.0 - glm::dot(wi, h), 5.0);
  }
  return sum / kSamples;
}

}  // namespace

double sg_albedo(double sharpness, double nv) {
  const glm::dvec3 wo = view_at(nv);
  const double cut = -std::expm1(-sharpness);  // share of the lobe in the upper hemisphere
  double sum = 0.0;
  for (int i = 0; i < kSamples; ++i) {
    // Half vectors with the density of the lobe; d omega_i = 4 (wo.h) d omega_h.
    const glm::dvec3 h = spiral(i, 1.0 + std::log1p(-cut * (i + 0.5) / kSamples) / sharpness);
    const double vh = glm::dot(wo, h), nl = 2.0 * vh * h.z - nv;
    if (vh > 0.0 && nl > 0.0) sum += 4.0 * vh * nl;
  }
  return sum / kSamples * 2.0 * std::numbers::pi * cut / sharpness;
}

Image reflectance_table(int size) {
  const Image base = split_sum_table(size);
  Image table(size, size, 4);
  parallel_for(0, size, [&](int x) {
    const double nv = (x + 0.5) / size, weight = mean_schlick_weight(nv);
    for (int y = 0; y < size; ++y) {
      table.at(x, y, 0) = base.at(x, y, 0);
      table.at(x, y, 1) = base.at(x, y, 1);
      table.at(x, y, 2) = static_cast<float>(sheen_albedo(nv, (y + 0.5) / size));
      table.at(x, y, 3) = static_cast<float>(weight);
    }
  });
  return table;
}

const Image& reflectance_table() {
  static const Image table = reflectance_table(64);
  return table;
}

Image sg_albedo_table(int size) {
  Image table(size, size, 1);
  parallel_for(0, size, [&](int y) {
    const double sharpness = std::exp2(kSgTableLog2Begin + (kSgTableLog2End - kSgTableLog2Begin) * y / (size - 1));
    for (int x = 0; x < size; ++x) {
      const double root = (x + 0.5) / size;
      table.at(x, y) = static_cast<float>(std::log(std::max(sg_albedo(sharpness, root * root), 1e-30)));
    }
  });
  return table;
}

}  // namespace maquette
