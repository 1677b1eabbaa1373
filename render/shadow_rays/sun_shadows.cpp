#include "render/shadow_rays/sun_shadows.h"

#include <atomic>

#include "render/bake/scene_bakes.h"
#include "render/environment/environment_buffers.h"
#include "render/frame/constants.h"
#include "render/gbuffer/surfaces.h"
#include "render/math/shared_formulas.h"
#include "render/reference/path_scene.h"
#include "render/reference/traversal.h"
#include "render/views/read_texture.h"
#include "scenes/parallel.h"

namespace maquette {

namespace shared {
#include "shadow_rays/sun_ray.glsl"
}  // namespace shared

namespace {

/// Direction of the world of one of the environment, as in shaders/shared/frame.glsl.
glm::vec3 world_from_environment(const glm::vec4& environment, const glm::vec3& d) {
  return {environment.x * d.x + environment.y * d.z, d.y, -environment.y * d.x + environment.x * d.z};
}

}  // namespace

void SunShadows::begin(const Surfaces& surfaces, std::size_t points) {
  of_ = surfaces.revision();
  places_.assign(points, SurfacePlace());
  facing_.clear();
}

std::size_t SunShadows::trace(const LayerContext& layer, const SunBuffers& sun) {
  if (facing_.empty()) {
    const auto words = read_texture<std::uint32_t>(layer.surfaces.surface(), GL_RGBA_INTEGER, GL_UNSIGNED_INT, 4);
    facing_.resize(places_.size());
    for (std::size_t i = 0; i < facing_.size(); ++i)
      facing_[i] = shared::direction_from_octahedral(glm::unpackSnorm2x16(words[4 * i]) * 0.5f + 0.5f);
  }
  const PathScene& scene = *layer.frame.bakes.shadow_scene().scene();
  const glm::vec4 turn = layer.constants.environment;
  std::vector<glm::vec3> directions;
  for (const glm::vec3& d : sun.sun_directions)
    directions.push_back(
        unpack_ray_direction(glm::packUnorm2x16(shared::octahedral_from_direction(world_from_environment(turn, d)))));
  const glm::vec3 first = world_from_environment(turn, sun.sun_directions.front());
  const std::uint32_t seed = static_cast<std::uint32_t>(layer.constants.sampling.w) ^ shared::kSunSeed;
  const auto width = static_cast<std::size_t>(layer.frame.size().grid_width());
  passed_.assign(places_.size(), glm::vec3(0.0f));
  std::atomic<std::size_t> traced = 0;
  parallel_ranges<std::size_t>(0, places_.size(), 256, [&](const auto& range) {
    std::size_t own = 0;
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      const SurfacePlace& place = places_[i];
      if (place.normal == glm::vec3(0.0f) || glm::dot(facing_[i], first) < -shared::kSunRadius) continue;
      const auto x = static_cast<std::uint32_t>(i % width), y = static_cast<std::uint32_t>(i / width);
      const glm::vec3& direction =
          directions[shared::sun_ray(shared::hash_pixel(x, y, seed), 0, static_cast<std::uint32_t>(directions.size()))];
      passed_[i] = transmittance(scene, {ray_origin(place, direction), direction, 0.0f, 3.4e38f});
      ++own;
    }
    traced += own;
  });
  list_lit(layer.surfaces);
  return traced;
}

void SunShadows::list_lit(const Surfaces& surfaces) {
  const GridSize& size = surfaces.size();
  const TileList& all = surfaces.tiles();
  if (lit_.counts.size() != all.counts.size() || lit_.band_tiles != all.band_tiles)
    lit_ = make_tile_list(size, surfaces.band_rows());
  const auto side = static_cast<std::size_t>(kTileSide), width = static_cast<std::size_t>(size.grid_width()),
             height = static_cast<std::size_t>(size.grid_height()),
             band_rows = all.counts.size() > 1 ? static_cast<std::size_t>(surfaces.band_rows()) : height;
  const std::size_t across = (width + side - 1) / side, down = (height + side - 1) / side;
  std::vector<bool> reached(across * down, false);
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x)
      if (passed_[y * width + x] != glm::vec3(0.0f)) reached[y / side * across + x / side] = true;
  std::vector<std::vector<unsigned>> bands(all.counts.size());
  for (std::size_t k = 0; k < reached.size(); ++k)
    if (reached[k])
      bands[k / across * side / band_rows].push_back(static_cast<unsigned>(k % across | k / across << 16u));
  for (std::size_t b = 0; b < bands.size(); ++b) {
    lit_.counts[b] = static_cast<int>(bands[b].size());
    if (bands[b].empty()) continue;
    const std::vector<unsigned> ordered = ordered_tiles(std::move(bands[b]));
    lit_.tiles.update(b * static_cast<std::size_t>(lit_.band_tiles) * sizeof(unsigned),
                      ordered.size() * sizeof(unsigned), ordered.data());
  }
}

}  // namespace maquette
