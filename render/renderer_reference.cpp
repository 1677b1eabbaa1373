// Mode reference inside the renderer: the path tracer's picture as a frame.
#include <algorithm>
#include <chrono>
#include <limits>

#include "render/reference/shared_formulas.h"
#include "render/renderer_impl.h"

namespace maquette {

namespace {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point from) {
  return std::chrono::duration<double, std::milli>(Clock::now() - from).count();
}

/// In a window: how long a frame waits for the first picture of a new view, and for a better one.
constexpr std::chrono::milliseconds kFirstPatience{200}, kPatience{50};

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
  r.adaptive = request.settings.get_bool("reference.adaptive");
  return r;
}

int asked_paths(const FrameRequest& request) {
  return request.samples > 0 ? request.samples : request.settings.get_int("reference.samples");
}

}  // namespace

/// Traces `asked_paths` more and waits for them.
void Renderer::Impl::trace_reference(const FrameRequest& request, bool accumulate) {
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
  if (!r.picture || !accumulate || !(r.request == request)) {
    r.picture.emplace(r.scene, picture_request(request));
    accumulated = 0;
  }
  r.picture->add(asked_paths(request), {}, {}, request.deadline);
  ++accumulated;
  r.news = {r.picture->mean(), r.picture->samples(), r.picture->relative_error(), r.picture->counts()};
}

/// Takes what the worker has, and sees that it works on what is asked.
void Renderer::Impl::watch_reference(const FrameRequest& request) {
  ReferenceFrame& r = reference;
  const bool first = !r.worker;
  if (first) r.worker = std::make_unique<ReferenceWorker>();
  const bool other_scene = first || r.scene_epoch != epoch;
  const bool changed = other_scene || !(r.request == request);
  if (changed) {
    ReferenceWorker::Job job;
    if (other_scene) {
      job.scene = std::make_shared<const Scene>(edited_scene());
      job.geometry = std::make_shared<const FlatGeometry>(buffers->geometry());
      job.environment = environment->shared_environment();
      job.variant = request.variant;
    }
    job.picture = picture_request(request);
    r.scene_epoch = epoch;
    r.worker->submit(std::move(job));
  }
  if (auto news = r.worker->take(changed ? kFirstPatience : kPatience))
    r.news = std::move(*news);
  else if (changed)
    r.news.paths = 0;  // the old picture stays until there is one
  if (r.news.mean.width == 0) r.news.mean = Image(request.width, request.height, 4);
  accumulated = std::max(r.news.paths, 1);
}

FrameStats Renderer::Impl::render_reference(const FrameRequest& request, FramePlan plan, bool accumulate) {
  const Clock::time_point begin = Clock::now();
  if (interactive)
    watch_reference(request);
  else
    trace_reference(request, accumulate);
  ReferenceFrame& r = reference;
  r.request = request;
  r.texture_stale = true;
  drawn_epoch = epoch;
  last_request = request;
  last_plan = plan;
  FrameStats stats;
  stats.plan = std::move(plan);
  stats.accumulated_frames = accumulated;
  stats.visible_pixels = stats.shaded_pixels = r.news.counts.covered_pixels;
  stats.shading_samples = r.news.counts.paths;
  stats.technique["paths"] = static_cast<double>(r.news.counts.paths);
  stats.technique["rays"] = static_cast<double>(r.news.counts.rays);
  if (r.news.relative_error > 0.0) stats.estimated_error = r.news.relative_error;
  stats.frame_ms = milliseconds_since(begin);
  stats.passes = {{"trace", stats.frame_ms}};
  return stats;
}

std::optional<Image> Renderer::read_variance() const {
  const ReferenceFrame& r = impl_->reference;
  if (!impl_->shows_reference() || !r.picture) return std::nullopt;
  return r.picture->variance();
}

Renderer::PathSnapshot Renderer::path_snapshot() const {
  impl_->require_ready();
  return {impl_->edited_scene(), impl_->environment->shared_environment(), impl_->buffers->geometry()};
}

const Texture& Renderer::Impl::picture() {
  if (!shows_reference()) return targets->picture;
  ReferenceFrame& r = reference;
  if (r.texture_stale) {
    const Image& image = r.news.mean;
    if (r.texture.width() != image.width || r.texture.height() != image.height)
      r.texture = Texture::make_2d("reference", GL_RGBA32F, image.width, image.height);
    r.texture.upload(0, image.width, image.height, GL_RGBA, GL_FLOAT, image.data.data());
    r.texture_stale = false;
  }
  return r.texture;
}

/// Every triangle is tried: a click is rare, and 360,000 take a few milliseconds.
Renderer::Pick Renderer::Impl::pick_traced(int x, int y) const {
  const FlatGeometry& g = buffers->geometry();
  const int width = last_request.width, height = last_request.height;
  const CameraFrame camera = camera_frame(last_request);
  const glm::vec2 ndc((2.0f * static_cast<float>(x) + 1.0f) / static_cast<float>(width) - 1.0f,
                      1.0f - (2.0f * static_cast<float>(y) + 1.0f) / static_cast<float>(height));
  const glm::vec3 ray = shared::camera_ray(camera.forward, camera.right * camera.tan_x, camera.up * camera.tan_y, ndc);
  Pick pick;
  float nearest = std::numeric_limits<float>::max();
  for (std::size_t i = 0; i < g.items.size(); ++i) {
    const DrawItem& item = g.items[i];
    const Material& m = material_of_item(i);
    if (!buffers->visible(i) || m.glass || m.alpha_mode == AlphaMode::blend) continue;
    const bool culled = !shows_both_sides(i);
    for (std::uint32_t k = item.first_index; k + 2 < item.first_index + item.index_count; k += 3) {
      const glm::vec3 a = g.positions[g.indices[k]], e1 = g.positions[g.indices[k + 1]] - a,
                      e2 = g.positions[g.indices[k + 2]] - a, normal = glm::cross(e1, e2);
      const shared::TriangleHit hit = shared::intersect_plane_of_triangle(camera.eye, ray, a, e1, e2);
      const bool inside =
          hit.barycentric.x >= 0.0f && hit.barycentric.y >= 0.0f && hit.barycentric.x + hit.barycentric.y <= 1.0f;
      if (!inside || hit.depth < camera.near_m || hit.depth >= nearest) continue;
      if (culled && glm::dot(normal, ray) > 0.0f) continue;
      nearest = hit.depth;
      pick = {true,
              item.node,
              item.primitive,
              buffers->material(i),
              camera.eye + ray * hit.depth,
              glm::normalize(glm::dot(normal, ray) > 0.0f ? -normal : normal)};
    }
  }
  return pick;
}

}  // namespace maquette
