#include "render/views/debug_views.h"

#include <algorithm>
#include <cmath>

#include "render/math/shared_formulas.h"
#include "render/picture/tonemap.h"
#include "render/views/false_color.h"
#include "render/views/read_texture.h"

namespace maquette {

namespace {

glm::vec3 decode_normal(std::uint32_t packed) {
  const auto part = [](std::uint32_t v) {
    return std::clamp(static_cast<float>(static_cast<std::int16_t>(v & 0xffff)) / 32767.0f, -1.0f, 1.0f);
  };
  const float u = part(packed), v = part(packed >> 16);
  glm::vec3 n(u, 1.0f - std::abs(u) - std::abs(v), v);
  if (n.y < 0.0f) {
    n.x = (1.0f - std::abs(v)) * (u >= 0.0f ? 1.0f : -1.0f);
    n.z = (1.0f - std::abs(u)) * (v >= 0.0f ? 1.0f : -1.0f);
  }
  return glm::normalize(n);
}

glm::vec3 decode_base_color(std::uint32_t packed) {
  constexpr int kBias = 34;  // kBaseColorBias
  const glm::vec3 root = shared::unpack_rgb9e5(packed, kBias);
  return root * root;
}

/// Scaled so that what is seen (alpha 1) has the mean 0.2.
Image at_mean_grey(Image values) {
  double sum = 0.0, count = 1e-30;
  for (std::size_t i = 0; i < values.data.size(); i += 4) {
    if (values.data[i + 3] <= 0.0f || values.data[i + 1] <= 0.0f) continue;  // nothing is shown there
    sum += static_cast<double>(values.data[i + 1]);
    count += 1.0;
  }
  const auto scale = static_cast<float>(0.2 * count / std::max(sum, 1e-30));
  for (std::size_t i = 0; i < values.data.size(); ++i)
    if (i % 4 != 3) values.data[i] *= scale;
  return values;
}

}  // namespace

std::vector<DebugViewInfo> debug_views(const Registry& registry) {
  std::vector<DebugViewInfo> views{
      {"depth"}, {"normal", "", ViewColors::normal}, {"base_color", "", ViewColors::color}, {"material"}};
  const std::vector<DebugViewInfo> more = registry.views();
  views.insert(views.end(), more.begin(), more.end());
  return views;
}

std::optional<PointValue> view_of_surfaces(const std::string& name, const Surfaces& surfaces) {
  const auto of_surface = [&](auto value) {
    return value_of_texels<std::uint32_t>(surfaces.surface(), GL_RGBA_INTEGER, GL_UNSIGNED_INT, 1, value);
  };
  if (name == "normal") return of_surface([](const std::uint32_t* g) { return decode_normal(g[0]); });
  if (name == "base_color") return of_surface([](const std::uint32_t* g) { return decode_base_color(g[1]); });
  if (name == "material")
    return of_surface([](const std::uint32_t* g) { return glm::vec3(static_cast<float>(g[2] >> 16)); });
  if (name == "depth")
    return [w = surfaces.size().grid_width(), depth = read_texture<float>(surfaces.depth(), GL_RED, GL_FLOAT, 1)](
               int x, int y) { return glm::vec3(depth[static_cast<std::size_t>(y * w + x)]); };
  return std::nullopt;
}

Image image_of_views(const GridSize& size, const std::vector<LayerView>& layers) {
  Image image(size.grid_width(), size.grid_height(), 4);
  for (const LayerView& layer : layers) {
    const std::vector<float> depth = read_texture<float>(layer.surfaces.depth(), GL_RED, GL_FLOAT, 1);
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        const bool surface = depth[static_cast<std::size_t>(y * image.width + x)] > 0.0f;
        if (!surface && (!layer.sky || image.at(x, y, 3) > 0.0f)) continue;
        const glm::vec3 v = surface ? layer.value(x, y) : layer.sky(x, y);
        for (int c = 0; c < 3; ++c) image.at(x, y, c) = v[c];
        image.at(x, y, 3) = 1.0f;
      }
  }
  return image;
}

Image picture_of_view(const Image& values, ViewColors colors) {
  if (colors == ViewColors::radiance) return tone_map(at_mean_grey(values), 0.0f, "pbr-neutral");
  if (colors == ViewColors::scale) return false_color_image(values);
  Image picture = values;
  for (std::size_t i = 0; i < picture.data.size(); ++i) {
    if (i % 4 == 3) continue;
    float& v = picture.data[i];
    v = colors == ViewColors::normal ? (picture.data[i - i % 4 + 3] > 0.0f ? 0.5f * v + 0.5f : 0.0f)
                                     : std::pow(std::max(v, 0.0f), 1.0f / 2.2f);
  }
  return picture;
}

}  // namespace maquette
