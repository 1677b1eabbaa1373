#include "render/glossy/glossy.h"

#include <algorithm>
#include <array>

#include "render/bake/scene_bakes.h"
#include "render/gl/bindings.h"
#include "render/indirect/bind.h"
#include "render/views/read_texture.h"
#include "scenes/node_paths.h"

namespace maquette {

namespace {

ShaderVariant glossy_variant(bool measured, bool indirect) {
  return {"reflections/glossy.comp", "", {{"MEASURED", flag(measured)}, {"INDIRECT", flag(indirect)}}};
}
ShaderVariant rays_variant(bool measured, bool exact) {
  return {"reflections/glossy_rays.comp", "", {{"MEASURED", flag(measured)}, {"EXACT", flag(exact)}}};
}
ShaderVariant tiles_variant(bool measured) {
  return {"reflections/glossy_tiles.comp", "", {{"MEASURED", flag(measured)}}};
}

bool has_measured(const MirroredScene& scene) { return scene.frame.scene.facts().measured_count > 0; }

}  // namespace

std::vector<ShaderVariant> Glossy::shader_variants() {
  std::vector<ShaderVariant> variants;
  for (const bool measured : {false, true})
    for (const ShaderVariant& variant :
         {tiles_variant(measured), rays_variant(measured, false), rays_variant(measured, true),
          glossy_variant(measured, false), glossy_variant(measured, true)})
      variants.push_back(variant);
  return variants;
}

std::vector<std::size_t> named_glossy_items(const SceneState& scene, const ReflectorSet& reflectors,
                                            const std::vector<std::string>& names) {
  std::vector<std::size_t> named;
  if (names.empty()) return named;
  const std::vector<bool> smooth = glossy_items(scene, kMaxGlossyRoughness);
  const std::set<int> called = called_nodes(scene.scene(), std::set<std::string>(names.begin(), names.end()));
  for (std::size_t i = 0; i < smooth.size() && named.size() < kMaxReflectors; ++i) {
    const int node = scene.geometry().items[i].node;
    if (!smooth[i] || node < 0 || reflectors.is_mirror(i)) continue;
    if (called.contains(node)) named.push_back(i);
  }
  return named;
}

int glossy_in_view(const SceneState& scene, const ReflectorSet& reflectors, const FrameRequest& request,
                   const glm::mat4& clip) {
  const auto roughness = static_cast<float>(request.settings.get_double("reflections.glossy"));
  std::vector<bool> smooth =
      roughness > 0.0f ? glossy_items(scene, roughness) : std::vector<bool>(scene.geometry().items.size(), false);
  for (const std::size_t i : named_glossy_items(scene, reflectors, request.reflectors)) smooth[i] = true;
  int count = 0;
  for (std::size_t i = 0; i < smooth.size(); ++i)
    count += smooth[i] && !reflectors.is_mirror(i) && scene.buffers().visible(i) &&
             may_be_seen(clip, scene.buffers().bounds(i));
  return count;
}

void Glossy::clear() { *this = Glossy(); }

void Glossy::rest() {
  Glossy resting;
  resting.technique_ = std::move(technique_);
  resting.technique_name_ = std::move(technique_name_);
  *this = std::move(resting);
}

void Glossy::set_uniforms(const MirroredScene& scene, const Program& program) const {
  const FrameRequest& request = scene.frame.request;
  std::array<glm::ivec2, kMaxReflectors> triangles{};
  const std::vector<std::size_t> named = named_glossy_items(scene.frame.scene, scene.reflectors, request.reflectors);
  for (std::size_t k = 0; k < named.size(); ++k) {
    const DrawItem& item = scene.frame.scene.geometry().items[named[k]];
    triangles[k] = glm::ivec2(item.first_index, item.first_index + item.index_count) / 3;
  }
  glProgramUniform2iv(program.get(), program.location("u_named"), static_cast<GLsizei>(kMaxReflectors),
                      &triangles[0].x);
  program.set("u_named_count", static_cast<int>(named.size()));
  program.set("u_roughness", static_cast<float>(request.settings.get_double("reflections.glossy")));
  program.set("u_divisor", rays_.targets().divisor);
}

void Glossy::find_tiles(const MirroredScene& scene) {
  const Surfaces& surfaces = scene.layers.front().context.surfaces;
  if (tiles_.counts.size() != surfaces.tiles().counts.size() ||
      tiles_.tiles.bytes() != surfaces.tiles().tiles.bytes()) {
    tiles_ = make_tile_list(surfaces.size(), surfaces.band_rows());
    counter_ = TileCounter(tiles_.counts.size());
  }
  tiles_.band_tiles = surfaces.tiles().band_tiles;
  const Program& program =
      counter_.begin(&scene.frame.programs, tiles_variant(has_measured(scene)), surfaces.band_rows(), tiles_, nullptr);
  set_uniforms(scene, program);
  dispatch_tiles(program, surfaces.tiles(), kPerTile);
  counter_.end(&tiles_, nullptr);
  const GridSize& grid = scene.frame.size();
  if (!light_ || light_.width() != grid.grid_width() || light_.height() != grid.grid_height())
    light_ = Texture::make_2d("glossy light", GL_RGBA32F, grid.grid_width(), grid.grid_height());
}

void Glossy::cast_rays(const MirroredScene& scene, bool exact) {
  const ReflectionTargets& t = rays_.targets();
  const float none[4] = {};
  for (const GLuint image : {light_.get(), t.ray_origin.get(), t.ray_direction.get()})
    glClearTexImage(image, 0, GL_RGBA, GL_FLOAT, none);
  const Program& program = scene.frame.programs.get(rays_variant(has_measured(scene), exact));
  set_uniforms(scene, program);
  if (exact)
    program.set("u_frame_at_rest", scene.frame.accumulated);
  else
    scene.frame.bakes.octree().buffers().set_uniforms(program);
  glBindImageTexture(kImageRayOrigin, t.ray_origin.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(kImageRayDirection, t.ray_direction.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(kImageLobeWidth, t.focus.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R16F);
  dispatch_tiles(program, tiles_, t.divisor == 1 ? kPerPoint : t.divisor == 2 ? kPerFourPoints : kPerBlock);
}

void Glossy::run(const MirroredScene& scene, const Technique& technique, const Key& surfaces, bool averages_points) {
  const FrameContext& frame = scene.frame;
  const bool exact = technique.can.is_exact, rests = frame.accumulated > 0, varies = exact && rests;
  const int divisor = reflection_divisor(frame.request.settings, varies);
  frame.timer().count_all_as("glossy");
  const Key now = Key::of(surfaces, frame.scene.revisions().all(), frame.bakes.all(), frame.request.reflectors,
                          frame.request.settings, technique.name, varies);
  const bool same = rays_.has_images() && traced_ == now;
  rays_.fit(frame.size(), divisor);
  ReflectionTargets& t = rays_.targets();
  if (!technique_ || technique_name_ != technique.name) technique_ = technique.make_glossy();
  technique_name_ = technique.name;
  const bool reuses = same && frame.request.settings.get_bool("shading.reuse"), kept = reuses && !varies;
  if (!reuses) find_tiles(scene);
  if (!kept) cast_rays(scene, exact);
  rays_.bind_constants(scene);
  rays_.follow(scene, {.technique = *technique_,
                       .keeps_hits = kept,
                       .glossy = true,
                       .shadow_rays = rests,
                       .averages = rests && averages_points,
                       .continues = same && rests});
  traced_ = now;
  scene.bind_layer(0);
  const bool baked = scene.layers.front().context.plan.indirect == "baked";
  const Program& program = frame.programs.get(glossy_variant(has_measured(scene), baked));
  set_uniforms(scene, program);
  program.set("u_sky_by_rays", varies && scene.layers.front().context.plan.shadow_rays ? 1 : 0);
  program.set("u_lift_m", exact ? 0.0f : frame.bakes.octree().buffers().cell_m());
  if (baked) bind_indirect(program, frame.scene, nearest_bake(frame.bakes.indirect()));
  glBindTextureUnit(kUnitRayOrigin, t.ray_origin.get());
  glBindTextureUnit(kUnitRayDirection, t.ray_direction.get());
  glBindTextureUnit(kUnitGlossyRadiance, t.radiance.get());
  glBindImageTexture(kImageGlossy, light_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  dispatch_tiles(program, tiles_, kPerPoint);
  frame.timer().end("glossy");
  frame.timer().count_all_as("");
}

Image Glossy::view() const {
  const ReflectionTargets& t = rays_.targets();
  const auto met = read_texture<float>(t.radiance, GL_RGBA, GL_FLOAT, 4);
  const auto direction = read_texture<float>(t.ray_direction, GL_RGBA, GL_FLOAT, 4);
  Image image(t.width, t.height, 4);
  for (std::size_t i = 0; i < met.size(); ++i)
    image.data[i] = i % 4 == 3 ? (direction[i] > 0.0f ? 1.0f : 0.0f) : met[i];
  return image;
}

}  // namespace maquette
