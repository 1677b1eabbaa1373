// Mode reference inside the renderer: the path tracer's picture as a frame.
#include <algorithm>
#include <chrono>

#include "render/renderer_impl.h"

namespace maquette {

namespace {

PictureRequest picture_request(const FrameRequest& request) {
  PictureRequest r;
  r.camera = request.camera;
  r.width = request.width;
  r.height = request.height;
  r.msaa = request.msaa;
  r.seed = request.seed;
  r.paths.transport =
      request.settings.get_string("reference.transport") == "direct" ? Transport::direct : Transport::full;
  r.paths.env_rotation_rad = request.env_rotation_rad;
  r.paths.env_scale = request.env_scale;
  r.paths.max_bounces = request.settings.get_int("reference.bounces");
  return r;
}

}  // namespace

FrameStats Renderer::Impl::render_reference(const FrameRequest& request, FramePlan plan, bool accumulate) {
  const auto begin = std::chrono::steady_clock::now();
  ReferenceFrame& r = reference;
  if (!r.scene || r.scene_epoch != epoch) {
    const Scene edited = edited_scene();
    r.picture.reset();
    r.scene = build_path_scene({.scene = edited,
                                .environment = environment->shared_environment(),
                                .variant = request.variant,
                                .geometry = &buffers->geometry(),
                                .library = &r.library});
    r.scene_epoch = epoch;
  }
  const auto traced = std::chrono::steady_clock::now();
  if (!r.picture || !accumulate || !(r.request == request)) {
    r.picture.emplace(r.scene, picture_request(request));
    r.request = request;
    accumulated = 0;
  }
  r.picture->add(request.samples > 0 ? request.samples : request.settings.get_int("reference.samples"));
  r.texture_stale = true;
  ++accumulated;
  drawn_epoch = epoch;
  last_request = request;
  last_plan = plan;
  const auto end = std::chrono::steady_clock::now();
  const auto milliseconds = [](auto from, auto to) {
    return std::chrono::duration<double, std::milli>(to - from).count();
  };
  FrameStats stats;
  stats.passes = {{"trace", milliseconds(traced, end)}};
  stats.plan = std::move(plan);
  stats.accumulated_frames = accumulated;
  const ReferenceCounts counts = r.picture->counts();
  stats.visible_pixels = stats.shaded_pixels = counts.covered_pixels;
  stats.shading_samples = counts.paths;
  stats.technique["paths"] = static_cast<double>(counts.paths);
  stats.technique["rays"] = static_cast<double>(counts.rays);
  if (const double error = r.picture->relative_error(); error > 0.0) stats.estimated_error = error;
  stats.frame_ms = milliseconds(begin, end);
  return stats;
}

Renderer::PathSnapshot Renderer::path_snapshot() const {
  impl_->require_ready();
  return {impl_->edited_scene(), impl_->environment->shared_environment(), impl_->buffers->geometry()};
}

const Texture& Renderer::Impl::picture() {
  if (!shows_reference()) return targets->picture;
  ReferenceFrame& r = reference;
  if (r.texture_stale) {
    const Image image = r.picture->mean();
    if (r.texture.width() != image.width || r.texture.height() != image.height)
      r.texture = Texture::make_2d("reference", GL_RGBA32F, image.width, image.height);
    r.texture.upload(0, image.width, image.height, GL_RGBA, GL_FLOAT, image.data.data());
    r.texture_stale = false;
  }
  return r.texture;
}

}  // namespace maquette
