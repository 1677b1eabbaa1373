#include "viewer/overlay_texture.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace maquette {

Texture overlay_texture(const Image& display, const char* label, GLenum filter) {
  std::vector<std::uint8_t> bytes(display.data.size());
  std::transform(display.data.begin(), display.data.end(), bytes.begin(),
                 [](float v) { return static_cast<std::uint8_t>(std::clamp(v, 0.0f, 1.0f) * 255.0f + 0.5f); });
  Texture texture = Texture::make_2d(label, GL_RGBA8, display.width, display.height);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTextureSubImage2D(texture.get(), 0, 0, 0, display.width, display.height, GL_RGBA, GL_UNSIGNED_BYTE, bytes.data());
  for (const GLenum name : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTextureParameteri(texture.get(), name, static_cast<GLint>(filter));
  for (const GLenum name : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTextureParameteri(texture.get(), name, GL_CLAMP_TO_EDGE);
  return texture;
}

ImTextureID texture_id(const Texture& texture) {
  return reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(texture.get()));
}

}  // namespace maquette
