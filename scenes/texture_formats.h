#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "scenes/scene.h"

namespace maquette {

/// What the first bytes say, whatever a file calls itself.
enum class TextureFormat { png, jpeg, webp, unknown };
TextureFormat texture_format(std::span<const std::byte> bytes);
/// `PNG`, `JPEG`, ...; other known formats by their name too.
std::string texture_format_name(std::span<const std::byte> bytes);

/// Width and height as the header of a PNG, JPEG or WebP image has them; 0 where they cannot be read.
glm::ivec2 texture_size(std::span<const std::byte> bytes);

/// Decodes a PNG, JPEG or WebP image to `width`, `height` and `rgba` of `image`; colour profiles and gamma are ignored,
/// as glTF 2.0 demands. Adds to `notes` what is not exact. Throws Error without a place: another format, damaged, cut
/// short, too large.
void decode_texture(std::span<const std::byte> bytes, TextureImage* image, std::vector<std::string>* notes);

}  // namespace maquette
