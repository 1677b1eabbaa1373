// The pictures of surface light fields that the dissertation has, of the seat.
#include "tests/benchmarks/slf_pictures.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>

#include "render/picture/tonemap.h"
#include "render/slf/direction_spline.h"
#include "scenes/image_io.h"

namespace maquette::bench {
namespace {

constexpr int kColumns = 3, kGap = 4;

/// Straight on, at 30 degrees to four sides, and near grazing. Local frame.
std::vector<glm::vec3> slice_directions() {
  std::vector<glm::vec3> directions{{0.0f, 0.0f, 1.0f}};
  for (const float azimuth : {0.0f, 90.0f, 180.0f, 270.0f}) {
    const float a = azimuth * std::numbers::pi_v<float> / 180.0f;
    directions.emplace_back(0.5f * std::cos(a), 0.5f * std::sin(a), std::sqrt(0.75f));
  }
  directions.emplace_back(0.0f, 0.94f, std::sqrt(1.0f - 0.94f * 0.94f));
  return directions;
}

/// Cells of the atlas that a part covers, and their texels.
class PartCells {
 public:
  PartCells(const Scene& scene, const FieldPictures& fields) : atlas_(fields.atlas) {
    low_ = glm::ivec2(atlas_.side);
    high_ = glm::ivec2(-1);
    shown_.assign(atlas_.texel_of_cell.size(), false);
    for (int y = 0; y < atlas_.side; ++y)
      for (int x = 0; x < atlas_.side; ++x) {
        const std::uint32_t texel = texel_at(x, y);
        if (texel == LightFieldAtlas::kNone) continue;
        const AtlasSide& side = atlas_.sides[atlas_.texels[texel].side];
        const int node = item_of_triangle(fields.geometry, side.triangle).node;
        if (scene.nodes[static_cast<std::size_t>(node)].name != fields.part) continue;
        shown_[static_cast<std::size_t>(y * atlas_.side + x)] = true;
        low_ = glm::min(low_, glm::ivec2(x, y));
        high_ = glm::max(high_, glm::ivec2(x, y));
      }
  }
  bool any() const { return high_.x >= low_.x; }
  glm::ivec2 size() const { return high_ - low_ + 1; }

  void draw(const std::function<glm::vec3(std::uint32_t texel)>& value, int left, int top, Image* image) const {
    for (int y = low_.y; y <= high_.y; ++y)
      for (int x = low_.x; x <= high_.x; ++x) {
        if (!shown_[static_cast<std::size_t>(y * atlas_.side + x)]) continue;
        const glm::vec3 v = value(texel_at(x, y));
        for (int c = 0; c < 3; ++c) image->at(left + x - low_.x, top + y - low_.y, c) = v[c];
        image->at(left + x - low_.x, top + y - low_.y, 3) = 1.0f;
      }
  }

 private:
  std::uint32_t texel_at(int x, int y) const {
    return atlas_.texel_of_cell[static_cast<std::size_t>(y * atlas_.side + x)];
  }

  const LightFieldAtlas& atlas_;
  glm::ivec2 low_{}, high_{};
  std::vector<bool> shown_;
};

/// Doubled in size, so that the brightest hundredth clips.
void save_shown(const std::string& path, const Image& image) {
  std::vector<float> light;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      if (image.at(x, y, 3) > 0.0f) light.push_back(image.at(x, y, 1));
  if (light.empty()) return;
  const auto at = light.begin() + static_cast<std::ptrdiff_t>(light.size() * 99 / 100);
  std::nth_element(light.begin(), at, light.end());
  constexpr int kZoom = 2;
  Image zoomed(kZoom * image.width, kZoom * image.height, 4);
  for (int y = 0; y < zoomed.height; ++y)
    for (int x = 0; x < zoomed.width; ++x)
      for (int c = 0; c < 4; ++c) zoomed.at(x, y, c) = image.at(x / kZoom, y / kZoom, c);
  save_png(path, tone_map(zoomed, -std::log2(std::max(*at, 1e-6f)), "linear"));
}

using Slice = std::function<glm::vec3(std::uint32_t texel, const glm::vec3& direction)>;

Image draw_slices(const PartCells& cells, const Slice& slice) {
  const std::vector<glm::vec3> directions = slice_directions();
  const int rows = (static_cast<int>(directions.size()) + kColumns - 1) / kColumns;
  const glm::ivec2 step = cells.size() + kGap;
  Image image(kColumns * step.x - kGap, rows * step.y - kGap, 4);
  for (std::size_t i = 0; i < directions.size(); ++i)
    cells.draw([&](std::uint32_t texel) { return slice(texel, directions[i]); },
               static_cast<int>(i) % kColumns * step.x, static_cast<int>(i) / kColumns * step.y, &image);
  return image;
}

Image below(const Image& above, const Image& other) {
  Image both(above.width, above.height + kGap + other.height, 4);
  std::copy(above.data.begin(), above.data.end(), both.data.begin());
  std::copy(other.data.begin(), other.data.end(), both.data.end() - static_cast<std::ptrdiff_t>(other.data.size()));
  return both;
}

}  // namespace

void save_slices(const Scene& scene, const FieldPictures& fields, const std::string& folder) {
  const PartCells cells(scene, fields);
  if (!cells.any()) return;
  std::filesystem::create_directories(folder);
  const auto path = [&](const char* name) { return (std::filesystem::path(folder) / name).string(); };
  const Lumisphere lumisphere(fields.incident.side);
  const DirectionSpline spline(lumisphere);
  save_shown(path("slices-incoming.png"), draw_slices(cells, [&](std::uint32_t texel, const glm::vec3& direction) {
               const float* bin = fields.incident.texel(texel).data() + 3 * lumisphere.bin_of(direction);
               return glm::vec3(bin[0], bin[1], bin[2]);
             }));
  const auto outgoing = [&](const LightField& field) {
    return draw_slices(cells, [&](std::uint32_t texel, const glm::vec3& direction) {
      const Eigen::VectorXf light = decode_texel(field, texel);
      glm::vec3 sum(0.0f);
      for (const DirectionSpline::Share& share : spline.shares(direction))
        for (int c = 0; c < 3; ++c) sum[c] += share.weight * light[3 * share.bin + c];
      return sum;
    });
  };
  const Image stored = outgoing(fields.stored), compressed = outgoing(fields.compressed);
  save_shown(path("slices-outgoing.png"), stored);
  save_shown(path("slices-compressed.png"), below(stored, compressed));
}

void save_beside_local_lighting(Stage& stage, const FrameRequest& r, const std::string& folder) {
  Renderer& renderer = stage.renderer();
  const auto draw = [&](const FrameRequest& request) {
    renderer.finish_background_work(request);
    renderer.render(request);
    return renderer.read_radiance();
  };
  const Image field = draw(r), covered = renderer.read_debug_view("slf_texels");
  FrameRequest local = r;
  local.mode = "uniform";
  local.samples = 256;
  local.settings.set("shading.visibility", std::string("none"));
  local.settings.set("shading.indirect", std::string("none"));
  const Image alone = draw(local);
  Image both(2 * field.width + kGap, field.height, 4);
  for (int y = 0; y < field.height; ++y)
    for (int x = 0; x < field.width; ++x)
      for (int c = 0; c < 4; ++c) {
        // Around the parts that have texels both show local lighting.
        const bool own = covered.at(x, y, 0) + covered.at(x, y, 1) + covered.at(x, y, 2) > 0.0f;
        both.at(x, y, c) = own ? field.at(x, y, c) : alone.at(x, y, c);
        both.at(field.width + kGap + x, y, c) = alone.at(x, y, c);
      }
  std::filesystem::create_directories(folder);
  save_shown((std::filesystem::path(folder) / "local.png").string(), both);
}

}  // namespace maquette::bench
