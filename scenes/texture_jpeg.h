#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "scenes/scene.h"

namespace maquette {

/// Decodes baseline and progressive JPEG into `image`. `set_size(width, height)` gives it its size, or throws. What is
/// worth a warning is added to `notes`. Throws Error where a part of the image is missing or damaged.
void decode_jpeg(std::span<const std::byte> bytes, const std::function<void(int, int)>& set_size, TextureImage* image,
                 std::vector<std::string>* notes);

}  // namespace maquette
