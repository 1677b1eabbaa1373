#pragma once

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "scenes/btf/btf.h"
#include "scenes/btf/factorise.h"

namespace maquette::test {

/// rho of small_btf before it is factorised: a diffuse part and a lobe about the mirrored view, by texel.
inline glm::vec3 small_btf_value(int texel, const glm::dvec3& light, const glm::dvec3& view) {
  const double mirrored = std::max(light.z * view.z - light.x * view.x - light.y * view.y, 0.0);
  const double lobe = std::pow(mirrored, 6.0), tilt = 0.5 + 0.5 * light.x * std::cos(1.7 * texel);
  return {0.10 + 0.15 * tilt + 0.20 * lobe * (texel % 3), 0.05 + 0.10 * tilt + 0.10 * lobe * (texel % 2),
          0.02 + 0.20 * lobe + 0.01 * texel};
}

/// A BTF of side x side texels, 19 lights (rings at 0, 30 and 60 degrees) and as many views, or the given ones.
inline std::shared_ptr<const Btf> small_btf(int side, int components, std::vector<glm::dvec3> views = {}) {
  std::vector<glm::dvec3> directions{glm::dvec3(0.0, 0.0, 1.0)};
  for (int i = 0; i < 18; ++i)
    directions.push_back(i < 6 ? direction_of_angles(30.0, 60.0 * i) : direction_of_angles(60.0, 30.0 * (i - 6)));
  auto btf = std::make_shared<Btf>();
  btf->name = "small";
  btf->width = btf->height = side;
  btf->components = components;
  btf->texel_m = 0.1;
  const BtfLights lights = make_btf_lights(directions);
  if (views.empty()) views = directions;
  for (const glm::dvec3& view : views) {
    std::vector<float> images;
    for (const glm::dvec3& light : directions)
      for (int t = 0; t < side * side; ++t) {
        const glm::vec3 rho = small_btf_value(t, light, view);
        images.insert(images.end(), {rho.x, rho.y, rho.z});
      }
    btf->views.push_back(factorise_btf_view(view, lights, components, &images));
  }
  complete_btf(btf.get());
  return btf;
}

}  // namespace maquette::test
