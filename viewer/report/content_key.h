#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/renderer.h"
#include "scenes/scene.h"

/// Keys of cached results, from everything that they depend on.
namespace maquette::report {

/// A hash of the values that are mixed in; equal sequences give equal keys.
class ContentKey {
 public:
  ContentKey& mix(std::string_view text);
  ContentKey& mix(double value);
  ContentKey& mix_bytes(std::span<const std::byte> bytes);
  template <typename T>
  ContentKey& mix_all(const std::vector<T>& values) {
    return mix_bytes(std::as_bytes(std::span(values)));
  }
  std::string text() const;  ///< 16 hexadecimal digits

 private:
  std::uint64_t value_ = 0;
};

/// Geometry, materials (measured tables by the bytes of their files), textures, lights. Milliseconds.
ContentKey scene_key(const Scene& scene);
/// Camera, size, seed, environment's rotation and scale, variant, settings that differ from their defaults.
void mix_request(const FrameRequest& request, ContentKey* key);

}  // namespace maquette::report
