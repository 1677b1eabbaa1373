#include "render/btf/small_geometry.h"

#include <cmath>
#include <numbers>

namespace maquette {

SmallGeometry flat_geometry(int side, const glm::vec3& diffuse, float specular, float alpha) {
  SmallGeometry g;
  g.side = side;
  const std::size_t cells = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
  g.heights.assign(cells, 0.0f);
  g.diffuse.assign(cells, diffuse);
  g.specular.assign(cells, specular);
  g.alpha = alpha;
  return g;
}

float ggx_lobe(float specular, float alpha, const glm::vec3& n, const glm::vec3& wi, const glm::vec3& wo) {
  const float ni = glm::dot(n, wi), no = glm::dot(n, wo);
  if (!(ni > 0.0f) || !(no > 0.0f)) return 0.0f;
  const glm::vec3 h = glm::normalize(wi + wo);
  const float nh = glm::dot(n, h), a2 = alpha * alpha, c = 1.0f - glm::dot(wi, h);
  const float d = nh * nh * (a2 - 1.0f) + 1.0f;
  const float masking = no * std::sqrt(a2 + (1.0f - a2) * ni * ni) + ni * std::sqrt(a2 + (1.0f - a2) * no * no);
  const float fresnel = specular + (1.0f - specular) * c * c * c * c * c;
  return fresnel * a2 * 0.5f / (std::numbers::pi_v<float> * d * d * masking);
}

}  // namespace maquette
