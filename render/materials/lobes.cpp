#include "render/materials/lobes.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "render/materials/brdf_sampler.h"
#include "render/materials/symmetric_brdf.h"

namespace maquette {

namespace {

constexpr int kSamples = 512;

}  // namespace

std::vector<glm::vec3> compute_lobe_directions(const BrdfTable& brdf, const BrdfTables& tables) {
  std::vector<glm::vec3> directions(kAlbedoCount, glm::vec3(0.0f, 0.0f, 2.0f / 3.0f));
  tbb::parallel_for(0, kAlbedoCount, [&](int i) {
    shared::BrdfSampler sampler(tables);
    const double theta = std::min(i * kHalfPi / (kAlbedoCount - 1), kHalfPi - 1e-3);
    const glm::vec3 wo(static_cast<float>(std::sin(theta)), 0.0f, static_cast<float>(std::cos(theta)));
    glm::dvec3 sum(0.0);
    double weight = 0.0;
    for (int k = 0; k < kSamples; ++k) {
      // Golden-ratio recurrence in two dimensions (Roberts 2018).
      const glm::vec2 u(static_cast<float>(std::fmod(0.5 + k * 0.7548776662466927, 1.0)),
                        static_cast<float>(std::fmod(0.5 + k * 0.5698402909980532, 1.0)));
      const auto s = sampler.sample_brdf(wo, u);
      if (!(s.pdf > 0.0f)) continue;
      const double y =
          static_cast<double>(luminance(glm::vec3(evaluate_brdf(brdf, glm::dvec3(s.wi), glm::dvec3(wo))))) *
          static_cast<double>(s.wi.z / s.pdf);
      sum += y * glm::dvec3(s.wi);
      weight += y;
    }
    if (!(weight > 0.0)) return;
    // Mirror symmetry leaves nothing across the plane of view and normal.
    directions[static_cast<std::size_t>(i)] = glm::vec3(glm::dvec3(sum.x, 0.0, sum.z) / weight);
  });
  return directions;
}

}  // namespace maquette
