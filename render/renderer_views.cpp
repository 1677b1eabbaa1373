// What the last frame shows: its picture, picks, debug views, the window.
#include <algorithm>
#include <utility>

#include "render/bake/scene_bakes.h"
#include "render/math/shared_formulas.h"
#include "render/picture/presenter.h"
#include "render/picture/tonemap.h"
#include "render/renderer_impl.h"
#include "render/views/debug_views.h"
#include "render/views/read_texture.h"
#include "scenes/error.h"
#include "scenes/suggest.h"

namespace maquette {

Image Renderer::read_radiance() const {
  if (impl_->shows_whole_picture()) return impl_->whole.mode->picture();
  const Texture& picture = impl_->targets.composer.picture();
  Image image(picture.width(), picture.height(), 4);
  image.data = read_texture<float>(picture, GL_RGBA, GL_FLOAT, 4);
  return image;
}

Image Renderer::read_display(float exposure_ev, const std::string& tonemap) const {
  const Composer& composer = impl_->targets.composer;
  if (impl_->shows_whole_picture() || !composer.points()) return tone_map(read_radiance(), exposure_ev, tonemap);
  Image points(composer.size().grid_width(), composer.size().grid_height(), 4);
  points.data = read_texture<float>(*composer.points(), GL_RGBA, GL_FLOAT, 4);
  return tone_map(points, exposure_ev, tonemap, composer.size().side);
}

std::optional<Image> Renderer::read_variance() const {
  if (!impl_->shows_whole_picture()) return std::nullopt;
  return impl_->whole.mode->variance();
}

Pick Renderer::pick(int x, int y) const {
  const Impl& s = *impl_;
  if (s.shows_whole_picture()) return pick_by_ray(s.scene, s.last.request, x, y);
  const GridSize& size = s.targets.raster.size();
  if (x < 0 || y < 0 || x >= size.width || y >= size.height) return {};
  const int gx = x * size.side + size.side / 2, gy = y * size.side + size.side / 2;
  std::uint32_t triangle = 0;
  glGetTextureSubImage(s.targets.raster.triangle().get(), 0, gx, gy, 0, 1, 1, 1, GL_RED_INTEGER, GL_UNSIGNED_INT, 4,
                       &triangle);
  if (triangle == 0) return {};
  float depth = 0.0f;
  for (std::size_t k = 0; k < s.layers.size() && depth <= 0.0f; ++k)
    glGetTextureSubImage(s.layers[k].surfaces.depth().get(), 0, gx, gy, 0, 1, 1, 1, GL_RED, GL_FLOAT, 4, &depth);
  const FrameConstants& c = s.last.constants;
  const glm::vec2 ndc((2.0f * static_cast<float>(gx) + 1.0f) / static_cast<float>(size.grid_width()) - 1.0f,
                      (2.0f * static_cast<float>(gy) + 1.0f) / static_cast<float>(size.grid_height()) - 1.0f);
  const shared::EyeRay ray =
      shared::camera_ray(glm::vec3(c.forward), glm::vec3(c.right), glm::vec3(c.up), c.eye.w, glm::vec2(ndc.x, -ndc.y));
  return pick_triangle(s.scene, triangle - 1, glm::vec3(c.eye) + ray.origin + ray.direction * depth, ray.direction);
}

std::optional<PointReport> Renderer::describe(const Pick& pick) const {
  if (!pick.hit) return std::nullopt;
  for (const ShadingPlan& layer : impl_->last.plan.layers) {
    const SceneBake* bake = layer.own_bake.empty() ? nullptr : impl_->bakes.own(layer.own_bake);
    if (!bake) continue;
    if (auto report = bake->describe(impl_->scene, pick.triangle, pick.back, pick.position)) return report;
  }
  return std::nullopt;
}

CompressionTableJob Renderer::compression_table() const {
  for (const ShadingPlan& layer : impl_->last.plan.layers) {
    const SceneBake* bake = layer.own_bake.empty() ? nullptr : impl_->bakes.own(layer.own_bake);
    if (CompressionTableJob job = bake ? bake->compression_table() : CompressionTableJob()) return job;
  }
  return {};
}

const std::vector<std::string>& Renderer::debug_view_names() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> names;
    for (const DebugViewInfo& view : debug_views(builtin_registry())) names.push_back(view.name);
    return names;
  }();
  return kNames;
}

namespace {

/// Throws the error for a view that the last frame does not have: says which technique has it.
[[noreturn]] void fail_view(const std::string& name, const std::string& mode, const Registry& registry) {
  for (const Technique& technique : registry.techniques)
    for (const DebugViewInfo& view : technique.views) {
      if (view.name != name) continue;
      if (technique.kind == TechniqueKind::mode)
        throw Error("--view", "'" + name + "' exists in mode " + technique.name + " only",
                    "add --mode " + technique.name);
      throw Error("--view", "'" + name + "' shows how samples are spent, and mode " + mode + " takes none",
                  "choose a mode that takes samples");
    }
  std::vector<std::string> names;
  for (const DebugViewInfo& view : debug_views(registry)) names.push_back(view.name);
  throw UsageError("--view", "unknown view '" + name + "'", did_you_mean(name, names));
}

}  // namespace

Image Renderer::Impl::read_view(const std::string& name) {
  if (shows_whole_picture())
    throw Error("--view", "'" + name + "' is a view of the modes that rasterise", "choose another --mode");
  if (name == "glossy") {
    if (!last.plan.glossy)
      throw Error("--view", "no opaque surface mirrors the scene here; the plan says why",
                  "add --reflections with a technique that follows single rays, and see left_out of --stats");
    return mirrors.glossy.view();
  }
  if (auto image = mirrors.reflections.view(name, !last.plan.reflections.empty(), last.constants))
    return std::move(*image);
  const FrameContext context{device, programs,       registry,     scene,     bakes,          light_samples,
                             frame,  targets.raster, last.request, last.plan, last.constants, last.accumulated};
  std::vector<LayerView> views;
  for (std::size_t k = 0; k < std::min(layers.size(), last.plan.layers.size()); ++k) {
    const Layer& layer = layers[k];
    const LayerContext at{context,        last.plan.layers[k], static_cast<int>(k),
                          layer.surfaces, layer.radiance,      layer.constants};
    auto value = view_of_surfaces(name, layer.surfaces);
    const PointValue sky = value ? PointValue() : layer.mode->sky_view(name, at);
    if (!value) value = layer.mode->view(name, at);
    if (value) views.push_back({layer.surfaces, std::move(*value), sky});
  }
  if (views.empty()) fail_view(name, last.plan.shading().mode, registry);
  return image_of_views(targets.raster.size(), views);
}

Image Renderer::read_debug_view(const std::string& name) const { return impl_->read_view(name); }

namespace {

ViewColors colors_of(const std::string& name, const Registry& registry) {
  for (const DebugViewInfo& view : debug_views(registry))
    if (view.name == name) return view.colors;
  return ViewColors::scale;
}

}  // namespace

Image debug_view_picture(const Image& values, const std::string& name) {
  return picture_of_view(values, colors_of(name, builtin_registry()));
}

const Texture& Renderer::Impl::picture() {
  if (!shows_whole_picture()) return targets.composer.picture();
  if (!whole.texture_stale) return whole.texture;
  const Image& image = whole.mode->picture();
  if (whole.texture.width() != image.width || whole.texture.height() != image.height)
    whole.texture = Texture::make_2d("picture of a mode", GL_RGBA32F, image.width, image.height);
  whole.texture.upload(0, image.width, image.height, GL_RGBA, GL_FLOAT, image.data.data());
  whole.texture_stale = false;
  return whole.texture;
}

void Renderer::present(int x, int y, int width, int height, float exposure_ev, const std::string& tonemap,
                       const std::string& debug_view) {
  Impl& s = *impl_;
  PresentRule rule{exposure_ev, tonemap_index(tonemap), 1};
  const glm::ivec4 rectangle(x, y, width, height);
  if (!debug_view.empty()) {
    const Image picture = picture_of_view(read_debug_view(debug_view), colors_of(debug_view, s.registry));
    Texture view = Texture::make_2d("debug view", GL_RGBA32F, picture.width, picture.height);
    view.upload(0, picture.width, picture.height, GL_RGBA, GL_FLOAT, picture.data.data());
    rule.curve = -1;
    maquette::present(view, rectangle, rule, &s.programs);
    return;
  }
  const Composer& composer = s.targets.composer;
  const bool by_points = !s.shows_whole_picture() && composer.points() && width == composer.size().width &&
                         height == composer.size().height;
  if (by_points) rule.side = composer.size().side;
  maquette::present(by_points ? *composer.points() : s.picture(), rectangle, rule, &s.programs);
}

}  // namespace maquette
