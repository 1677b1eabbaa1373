#include "render/shading/sampled_shading.h"

#include <algorithm>
#include <cmath>

#include "render/bake/scene_bakes.h"
#include "render/gl/bindings.h"
#include "render/views/read_texture.h"

namespace maquette {

namespace {

ShaderVariant shade_hits_variant(const ShadingPlan& plan, bool measured) {
  return {"shading/shade.comp",
          "",
          {{"REFLECTED", "1"},
           {"MEASURED", flag(measured)},
           {"VISIBILITY", visibility_define(plan)},
           {"LIGHTS", flag(plan.lights)}}};
}
ShaderVariant shade_hits_without_sun_variant(const ShadingPlan& plan, bool measured) {
  ShaderVariant variant = shade_hits_variant(plan, measured);
  variant.defines.emplace_back("SEPARATE_SUN", "1");
  return variant;
}

const ShaderVariant kMarkHits{
    "bandwidth/mark.comp",
    "",
    {{"REFLECTED", "1"}, {"BANDWIDTH", "0"}, {"REFINE", "0"}, {"TEXTURES", "0"}, {"VISIBILITY", "0"}}};

}  // namespace

std::string visibility_define(const ShadingPlan& plan) {
  return plan.visibility == "traced" ? "2" : plan.visibility == "baked" ? "1" : "0";
}

void set_sun(const Program& program, const SunBuffers& sun) {
  const auto inverse = [](double integral) { return integral > 0.0 ? static_cast<float>(1.0 / integral) : 0.0f; };
  glProgramUniform3f(program.get(), program.location("u_sun"), sun.least_luminance, inverse(sun.sun_sr),
                     inverse(sun.rest_integral));
}

ShaderVariant gather_variant(bool accumulate, bool textures) {
  return {"shading/gather.comp", "", {{"ACCUMULATE", flag(accumulate)}, {"TEXTURES", flag(textures)}}};
}

ShaderVariant shade_variant(const ShadingPlan& plan, bool measured) {
  ShaderVariant variant{
      "shading/shade.comp",
      "",
      {{"MEASURED", flag(measured)}, {"VISIBILITY", visibility_define(plan)}, {"LIGHTS", flag(plan.lights)}}};
  if (!measured && !plan.sheen) variant.defines.emplace_back("ANALYTIC_SHEEN", "0");
  if (!measured && !plan.clearcoat) variant.defines.emplace_back("ANALYTIC_COAT", "0");
  if (plan.sun_apart) variant.defines.emplace_back("SEPARATE_SUN", "1");
  return variant;
}

std::vector<ShaderVariant> SampledShading::shader_variants() {
  std::vector<ShaderVariant> variants{kMarkHits, {"shading/arguments.comp", "", {}}, gather_variant(false, false)};
  for (const char* visibility : {"none", "baked", "traced"})
    for (const bool lights : {false, true})
      for (const bool measured : {false, true}) {
        ShadingPlan plan;
        plan.visibility = visibility;
        plan.lights = lights;
        variants.push_back(shade_hits_variant(plan, measured));
        if (plan.visibility != "traced") variants.push_back(shade_hits_without_sun_variant(plan, measured));
        for (int lobes = 0; lobes < (measured ? 1 : 4); ++lobes)
          for (const bool sun_apart : {false, true}) {
            if (sun_apart && plan.visibility == "traced") continue;  // goes with rays, not with these
            plan.sheen = lobes & 1;
            plan.clearcoat = lobes & 2;
            plan.sun_apart = sun_apart;
            variants.push_back(shade_variant(plan, measured));
          }
      }
  return variants;
}

void SampledShading::fit(const GridSize& size, bool predicted) {
  lists_ = make_work_lists(size, predicted);
  marks_ = Texture::make_2d("marks", GL_RGBA8UI, size.grid_width(), size.grid_height());
}

void SampledShading::mark_band(const Marking& marking, std::size_t band, unsigned counters[16]) {
  lists_.bind();
  // Counts average to the base count over the picture; a band that needs far more than its share gets what fits.
  for (float scale = 1.0f; scale > 1e-3f;) {
    lists_.counters.clear_to_zero();
    marking.program.set("u_item_capacity", lists_.capacity);
    marking.program.set("u_sample_scale", scale);
    dispatch_tiles(marking.program, marking.tiles, kPerBlock, band);
    lists_.counters.read(0, 16 * sizeof(unsigned), counters);
    const unsigned wanted = std::max(counters[0], counters[8]);
    if (wanted > std::min(marking.most_items, static_cast<unsigned>(lists_.most)))
      scale *= 0.5f;
    else if (lists_.grow(wanted))
      lists_.bind();
    else
      break;
  }
}

void SampledShading::shade_lists(const FrameContext& frame, const ShadingPlan& plan, const unsigned counters[16],
                                 ShaderVariant (*variant)(const ShadingPlan&, bool), const Program& gather) {
  const SunBuffers* sun = plan.sun_apart && variant != shade_hits_variant ? frame.scene.environment().sun() : nullptr;
  if (sun) glBindTextureUnit(kUnitLightSamples, sun->rest_view.get());
  for (int list = 0; list < 2; ++list) {
    if (counters[8 * list] == 0) continue;
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferItems, lists_.items[list].get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferPartial, lists_.partial[list].get());
    const Program& program = frame.programs.get(variant(plan, list == 0));
    program.set("u_list", list);
    if (sun) set_sun(program, *sun);
    if (plan.visibility == "traced") frame.bakes.octree().buffers().set_uniforms(program);
    dispatch_indirect(program, list * 32 + 8);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferPoints, lists_.points[list].get());
    glBindTextureUnit(kUnitPartial, lists_.partial_view[list].get());
    gather.set("u_list", list);
    dispatch(gather, 256, 1);
  }
  if (sun) frame.scene.environment().bind();
}

void SampledShading::shade_hits(const HitShading& hits) {
  const ReflectionTargets& t = hits.targets;
  // Of whole blocks of mark.comp.
  const int rows = std::min(lists_.band_rows, lists_.capacity / (4 * kMostReflectedItems * t.width) * 4);
  for (int row = 0; row < t.height; row += rows) shade_hit_rows(hits, row, std::min(rows, t.height - row));
}

void SampledShading::shade_hit_rows(const HitShading& hits, int first_row, int rows) {
  const ReflectionTargets& t = hits.targets;
  ProgramCache& programs = hits.frame.programs;
  lists_.bind();
  lists_.counters.clear_to_zero();
  const Program& mark = programs.get(kMarkHits);
  glProgramUniform2i(mark.get(), mark.location("u_band"), first_row, rows);
  mark.set("u_item_capacity", lists_.capacity);
  mark.set("u_sample_scale", 1.0f);
  mark.set("u_frames", hits.frame.accumulated + 1);
  mark.set("u_panes", hits.panes);
  glBindImageTexture(kImageMarks, t.marks.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8UI);
  dispatch_list(mark, group_count(t.width, 4) * group_count(rows, 4));
  unsigned counters[16];
  lists_.counters.read(0, sizeof counters, counters);
  count_groups(lists_, &programs);
  glBindImageTexture(kImageRadiance, t.radiance.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  shade_lists(hits.frame, hits.plan, counters, hits.without_sun ? shade_hits_without_sun_variant : shade_hits_variant,
              programs.get(gather_variant(false, false)));
}

std::optional<PointValue> view_of_marks(const std::string& name, const Texture& marks) {
  const int channel = name == "shaded" ? 0 : name == "level" ? 1 : name == "samples" ? 2 : -1;
  if (channel < 0) return std::nullopt;
  return value_of_texels<std::uint8_t>(marks, GL_RGBA_INTEGER, GL_UNSIGNED_BYTE, 1, [channel](const std::uint8_t* m) {
    const float v = m[channel];
    return glm::vec3(channel == 2 && v > 0.0f ? std::exp2(v) : v);
  });
}

}  // namespace maquette
