#include "render/frustum.h"

#include <algorithm>

namespace maquette {

bool may_be_seen(const glm::mat4& clip_from_world, const Bounds& bounds) {
  int outside[5] = {};
  for (int k = 0; k < 8; ++k) {
    const glm::vec4 p =
        clip_from_world * glm::vec4(k & 1 ? bounds.max.x : bounds.min.x, k & 2 ? bounds.max.y : bounds.min.y,
                                    k & 4 ? bounds.max.z : bounds.min.z, 1.0f);
    outside[0] += p.x < -p.w;
    outside[1] += p.x > p.w;
    outside[2] += p.y < -p.w;
    outside[3] += p.y > p.w;
    outside[4] += p.w < 0.0f;
  }
  return std::none_of(outside, outside + 5, [](int n) { return n == 8; });
}

}  // namespace maquette
