#pragma once

#include <glm/glm.hpp>

namespace maquette {

/// Each component rounded to float and given as double again. Never as dvec3(vec3(v)): GCC 12 takes the way there and
/// back for nothing when it packs two components into one register (-O2, tree-slp-vectorize), so that nothing is
/// rounded.
inline glm::dvec3 rounded_to_float(const glm::dvec3& v) {
  glm::dvec3 out;
  for (int i = 0; i < 3; ++i) {
    const volatile float rounded = static_cast<float>(v[i]);
    out[i] = static_cast<double>(rounded);
  }
  return out;
}

}  // namespace maquette
