#include "render/prefilter/prefiltered_maps.h"

#include <glm/glm.hpp>

#include "scenes/error.h"

namespace maquette {

PrefilteredMaps::PrefilteredMaps(const std::string& label, const std::vector<Image>& maps) {
  std::vector<glm::vec4> texels(maps.size());
  for (std::size_t i = 0; i < maps.size(); ++i) {
    const Image& map = maps[i];
    texels[i] = glm::vec4(static_cast<float>(texels.size()), static_cast<float>(map.width),
                          static_cast<float>(map.height), static_cast<float>(maps.size()));
    for (std::size_t k = 0; k + 2 < map.data.size(); k += 3)
      texels.emplace_back(map.data[k], map.data[k + 1], map.data[k + 2], 0.0f);
  }
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &largest);
  // Offsets are stored as floats, which hold integers up to 2^24.
  if (texels.size() > static_cast<std::size_t>(largest) || texels.size() > (std::size_t{1} << 24))
    throw Error(label, std::to_string(texels.size()) + " texels are more than this driver can address",
                "use mode uniform or bandwidth");
  texels_ = Buffer::from(label, texels);
  view_ = Texture::make_buffer(label, GL_RGBA32F, texels_);
}

Texture upload_table(const std::string& label, const Image& table) {
  const bool scalar = table.channels == 1;
  Texture texture = Texture::make_2d(label, scalar ? GL_R32F : GL_RGBA32F, table.width, table.height);
  texture.upload(0, table.width, table.height, scalar ? GL_RED : GL_RGBA, GL_FLOAT, table.data.data());
  texture.set_filter(GL_LINEAR, GL_LINEAR);
  return texture;
}

}  // namespace maquette
