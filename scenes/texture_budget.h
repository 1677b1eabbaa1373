#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/scene.h"

namespace maquette {

inline std::size_t texels_of(const glm::ivec2& size) {
  return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
}

/// Texels that the images of a scene may have together: some for any file, more by the bytes that its images take, so
/// that a small file of empty images does not fill the memory; never more than a buffer of texels holds with mip
/// chains.
std::size_t most_texels(std::size_t encoded_bytes);

/// [image] how often images of these sizes are halved to have at most `most` texels together: those of the largest
/// sizes first, those of similar sizes alike.
std::vector<int> halvings_within(std::vector<glm::ivec2> sizes, std::size_t most);

/// Halves an image in width and height that many times. `srgb`: its colours are encoded by sRGB, and their light is
/// averaged.
void halve_image(TextureImage* image, int times, bool srgb);

}  // namespace maquette
