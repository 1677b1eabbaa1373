#include "render/sg/fit.h"

#include <algorithm>
#include <cmath>

#include "render/prefilter/reflectance_tables.h"

namespace maquette {

SgEnergy fit_energy(const SgFit& shape, const std::vector<glm::vec3>& albedo) {
  SgEnergy energy;
  energy.diffuse = shape.diffuse;
  for (std::size_t i = 0; i < albedo.size() * 7 / 8; ++i) energy.diffuse = glm::min(energy.diffuse, albedo[i]);
  for (std::size_t i = 0; i < albedo.size(); ++i) {
    const double theta = 1.5707963267948966 * static_cast<double>(i) / static_cast<double>(albedo.size() - 1);
    const double nv = std::max(std::cos(theta), 1e-3);  // as the shader's
    glm::vec3 factor(1.0f);
    for (int c = 0; c < 3; ++c) {
      double lobes = 0.0;
      for (const SgFit::Lobe& lobe : shape.lobes)
        lobes += static_cast<double>(lobe.amplitude[c]) * sg_albedo(static_cast<double>(lobe.sharpness[c]), nv);
      const double rest = std::max(0.0, static_cast<double>(albedo[i][c]) - static_cast<double>(energy.diffuse[c]));
      factor[c] = lobes > 1e-12 ? static_cast<float>(std::min(rest / lobes, 1e4)) : 0.0f;
    }
    energy.view_factor.push_back(factor);
  }
  return energy;
}

}  // namespace maquette
