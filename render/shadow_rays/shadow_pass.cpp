#include "render/shadow_rays/shadow_pass.h"

#include <atomic>
#include <cmath>

#include "render/bake/scene_bakes.h"
#include "render/gl/bindings.h"
#include "render/shadow_rays/point_rays.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {
/// Rays of each kind from each point of a frame that is alone.
constexpr int kSingleRays = 8;
}  // namespace

void ShadowPass::run(const LayerContext& layer, bool averages) {
  const FrameContext& frame = layer.frame;
  const int w = frame.size().grid_width(), h = frame.size().grid_height();
  const auto count = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
  if (!light_ || light_.width() != w || light_.height() != h)
    light_ = Texture::make_2d("light by shadow rays", GL_RGBA32F, w, h);
  const bool rests = frame.accumulated > 0, fits = sun_.size() == count;
  const Key lamps = Key::of(frame.scene.revisions().bounces(), frame.request.settings, frame.request.seed,
                            reinterpret_cast<std::uintptr_t>(frame.bakes.shadow_scene().scene().get()));
  const bool same_lamps = fits && layer.surfaces.kept() && lamps_of_ == lamps;
  const bool with_lamps = layer.plan.lights && (rests || !same_lamps);
  lamps_of_ = lamps;
  frames_ = averages && rests && fits ? frames_ + 1 : 1;
  if (frames_ == 1) {
    sun_.assign(count, glm::vec4(0.0f));
    sky_frames_ = 0;
  }
  if (layer.plan.sky_rays && sky_frames_ == 0) {
    sky_.assign(count, glm::vec4(0.0f));
    points_.assign(count, SkyPoint());
  }
  if (with_lamps) lamp_frames_ = averages && same_lamps ? lamp_frames_ + 1 : 1;
  if (!same_lamps || (with_lamps && lamp_frames_ == 1)) lamps_.assign(count, glm::vec4(0.0f));
  ray_count_ = 0;
  const std::size_t bytes = static_cast<std::size_t>(layer.surfaces.tiles().band_tiles) * 64 * sizeof(PointRays);
  if (rays_.bytes() < bytes) rays_ = Buffer("shadow rays", bytes);
  frame.timer().end("draw_rays");  // also where nothing is seen
  const SunBuffers* sun = layer.plan.sun_apart ? frame.scene.environment().sun() : nullptr;
  const bool any = rests || with_lamps || sun || layer.plan.sky_rays,
             stays = layer.surfaces.kept() && sun && sun->compact, known = stays && sun_shadows_.know(layer.surfaces),
             sun_first = known && !rests && !with_lamps && !layer.plan.sky_rays;
  if (sun_first) {
    ray_count_ += sun_shadows_.trace(layer, *sun);
    frame.timer().end("trace_rays");
  }
  if (stays && !known) sun_shadows_.begin(layer.surfaces, count);
  const int rounds = frame.request.single && !rests && !sun_first ? kSingleRays : 1;
  Drawn drawn{.tiles = sun_first ? sun_shadows_.lit() : layer.surfaces.tiles(),
              .lamps = with_lamps,
              .sun_first = sun_first,
              .learns = stays && !known};
  for (int round = 0; round < rounds; ++round) {
    if (round > 0) {
      ++frames_;
      lamp_frames_ += with_lamps ? 1 : 0;
    }
    drawn.number = frame.accumulated + round;
    for (std::size_t band = 0; any && band < drawn.tiles.counts.size(); ++band)
      if (drawn.tiles.counts[band] > 0) trace_band(layer, band, drawn);
    sky_frames_ += layer.plan.sky_rays ? 1 : 0;
  }
  sum_.resize(count);
  parallel_ranges<std::size_t>(0, count, 4096, [&](const auto& range) {
    for (std::size_t i = range.begin(); i != range.end(); ++i)
      sum_[i] = layer.plan.lights ? sun_[i] + lamps_[i] : sun_[i];
  });
  if (layer.plan.sky_rays) {
    // Where pictures are averaged, the filter narrows with them: their mean must not keep its blur.
    const int smoothed = std::max(averages ? sky_frames_ : frame.accumulated * frame.accumulated, rounds);
    const std::vector<glm::vec4>& smooth = filter_.run(points_, sky_, {w, h}, smoothed);
    for (std::size_t i = 0; i < count; ++i) sum_[i] += smooth[i] * glm::vec4(points_[i].base, 0.0f);
  }
  light_.upload(0, w, h, GL_RGBA, GL_FLOAT, sum_.data());
  frame.timer().end("trace_rays");
}

void ShadowPass::trace_band(const LayerContext& layer, std::size_t band, const Drawn& drawn) {
  const FrameContext& frame = layer.frame;
  const bool sky = layer.plan.sky_rays;
  glBindTextureUnit(kUnitTriangle, layer.surfaces.triangle().get());
  const std::vector<PointRays> rays = draw_point_rays(frame,
                                                      {.plan = layer.plan,
                                                       .tiles = drawn.tiles,
                                                       .band = band,
                                                       .sky = sky,
                                                       .lamps = drawn.lamps,
                                                       .all = drawn.learns,
                                                       .number = drawn.number},
                                                      &rays_);
  frame.timer().end("draw_rays");
  const PathScene& scene = *frame.bakes.shadow_scene().scene();
  const FlatGeometry& geometry = frame.scene.geometry();
  const auto width = static_cast<std::size_t>(light_.width());
  const float blend = 1.0f / static_cast<float>(frames_),
              lamp_blend = 1.0f / static_cast<float>(std::max(lamp_frames_, 1));
  const float sky_blend = 1.0f / static_cast<float>(sky_frames_ + 1);
  std::atomic<std::size_t> traced = 0;
  parallel_ranges<std::size_t>(0, rays.size(), 256, [&](const auto& range) {
    std::size_t own = 0;
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      const PointRays& p = rays[i];
      if (p.triangle == 0) continue;
      const std::size_t at = (p.pixel >> 16u) * width + (p.pixel & 65535u);
      if (drawn.sun_first) {
        sun_[at] = glm::vec4(p.sun * sun_shadows_.passed(at), 0.0f);
        continue;
      }
      const SurfacePlace place = place_of(geometry, p.triangle - 1, p.position);
      if (drawn.learns) sun_shadows_.set(at, place);
      if (sky) points_[at] = sky_point(layer.constants, p, place);
      const BroughtLight brought = trace_point(scene, p, place);
      own += brought.rays;
      sun_[at] += (glm::vec4(brought.sun, 0.0f) - sun_[at]) * blend;
      if (drawn.lamps) lamps_[at] += (glm::vec4(brought.lamp, 0.0f) - lamps_[at]) * lamp_blend;
      if (sky) sky_[at] += (glm::vec4(brought.sky / points_[at].base, 0.0f) - sky_[at]) * sky_blend;
    }
    traced += own;
  });
  ray_count_ += traced;
}

}  // namespace maquette
