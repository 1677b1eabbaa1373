#include "render/shadow_rays/hit_shadows.h"

#include "render/bake/scene_bakes.h"
#include "scenes/parallel.h"

namespace maquette {

void HitShadows::begin(const ReflectionTargets& t) {
  sum_.assign(static_cast<std::size_t>(t.width) * static_cast<std::size_t>(t.height), glm::vec4(0.0f));
  if (!light_ || light_.width() != t.width || light_.height() != t.height)
    light_ = Texture::make_2d("light at hits by shadow rays", GL_RGBA32F, t.width, t.height);
}

void HitShadows::add(const FrameContext& frame, const Layer& layer, const ReflectionTargets& t) {
  if (t.tiles.counts.empty() || t.tiles.counts[0] == 0) return;
  const std::size_t bytes = 64 * static_cast<std::size_t>(t.tiles.counts[0]) * sizeof(PointRays);
  if (rays_.bytes() < bytes) rays_ = Buffer("shadow rays of hits", bytes);
  const bool sky = layer.plan.sky_rays && layer.sky_frames > 0;
  const std::vector<PointRays> rays = draw_point_rays(
      frame, {.plan = layer.plan, .tiles = t.tiles, .sky = sky, .reflected = true, .number = frame.accumulated},
      &rays_);
  const PathScene& scene = *frame.bakes.shadow_scene().scene();
  const FlatGeometry& geometry = frame.scene.geometry();
  if (sky) {
    points_.assign(sum_.size(), SkyPoint());
    sky_.assign(sum_.size(), glm::vec4(0.0f));
  }
  const auto width = static_cast<std::size_t>(t.width);
  parallel_ranges<std::size_t>(0, rays.size(), 256, [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      const PointRays& p = rays[i];
      if (p.triangle == 0) continue;
      const std::size_t at = (p.pixel >> 16u) * width + (p.pixel & 65535u);
      const SurfacePlace place = place_of(geometry, p.triangle - 1, p.position);
      const BroughtLight brought = trace_point(scene, p, place);
      sum_[at] += glm::vec4(brought.sun + brought.lamp, 0.0f);
      if (!sky) continue;
      points_[at] = sky_point(layer.constants, p, place);
      sky_[at] = glm::vec4(brought.sky / points_[at].base, 0.0f);
    }
  });
  if (!sky) return;
  const std::vector<glm::vec4>& smooth = filter_.run(points_, sky_, {t.width, t.height}, layer.sky_frames);
  for (std::size_t i = 0; i < sum_.size(); ++i) sum_[i] += smooth[i] * glm::vec4(points_[i].base, 0.0f);
}

const Texture& HitShadows::light() {
  light_.upload(0, light_.width(), light_.height(), GL_RGBA, GL_FLOAT, sum_.data());
  return light_;
}

}  // namespace maquette
