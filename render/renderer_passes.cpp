// The passes of one frame, in the order of the plan.
#include <algorithm>
#include <cmath>

#include "render/renderer_impl.h"

namespace maquette {

namespace {

constexpr int kPredictionSamples = 8;  // directions a quad; neighbours pool to about 50

int groups(int count, int size) { return (count + size - 1) / size; }

ShaderVariant predict_variant(const FramePlan& plan, int measured, bool sky_variance) {
  return {"bandwidth/predict.comp",
          "",
          {{"MEASURED", flag(measured)},
           {"SHADOWED", visibility_define(plan)},
           {"LIGHTS", flag(plan.lights)},
           {"SKY_VARIANCE", flag(sky_variance)},
           {"SEEN_BANDWIDTHS", std::to_string(kSeenBandwidthCount)},
           {"PREDICTION_SAMPLES", std::to_string(kPredictionSamples)}}};
}

bool has_near_terms(const FramePlan& plan) { return plan.visibility != "none" || plan.lights; }

/// `first_only`: predicts the first quad alone of every other block of 2 x 2, whatever it shows.
ShaderVariant classify_variant(bool first_only) {
  return {"bandwidth/classify.comp", "", {{"FIRST_ONLY", flag(first_only)}}};
}

/// `coarse`: makes the pyramid's next level as well, which takes whole blocks of 2 x 2 quads.
ShaderVariant bandwidth_variant(const FramePlan& plan, bool first_only, bool coarse) {
  return {"bandwidth/bandwidth.comp",
          "",
          {{"TEXTURE_BANDWIDTH", flag(plan.texture_bandwidth)},
           {"NEAR", flag(has_near_terms(plan))},
           {"COARSE", flag(coarse)},
           {"FIRST_ONLY", flag(first_only)},
           {"PREDICTION_SAMPLES", std::to_string(kPredictionSamples)}}};
}

const ShaderVariant kOpen{"bandwidth/open.comp", "", {{"VISIBILITY", "1"}}};

ShaderVariant mark_variant(bool bandwidth, bool refine, bool textures, bool repainted, bool masks) {
  ShaderVariant variant{"bandwidth/mark.comp",
                        "",
                        {{"BANDWIDTH", flag(bandwidth)},
                         {"REFINE", flag(refine)},
                         {"TEXTURES", flag(textures)},
                         {"VISIBILITY", flag(masks && bandwidth && !refine)}}};
  if (repainted) variant.defines.emplace_back("REPAINTED", "1");
  return variant;
}

/// Levels up to this one are filled by tiles: cells of the coarser ones are larger than a tile, and few.
constexpr int kLastTileLevel = 2;

enum class FillStep {
  once,  ///< weights are found for this frame alone
  find,  ///< weights are found for the frames to come
  kept   ///< weights were found before
};

struct FillRule {
  bool textures = false, own = false;
  bool cubic = false, tiles = false;  ///< of levels above the finest, of levels within a tile
  FillStep step = FillStep::once;
  bool middle = false;  ///< of four points, else between two
};

ShaderVariant fill_variant(const FillRule& rule) {
  return {"bandwidth/fill.comp",
          "",
          {{"TEXTURES", flag(rule.textures)},
           {"CUBIC", flag(rule.cubic)},
           {"TILES", flag(rule.tiles)},
           {"OWN", flag(rule.own)},
           {"FIND", flag(rule.step == FillStep::find)},
           {"KEPT", flag(rule.step == FillStep::kept)},
           {"MIDDLE", flag(rule.middle)}}};
}

/// The finest level with several points a pixel, by listed quads.
ShaderVariant fill_quads_variant(bool textures, bool own) {
  ShaderVariant variant = fill_variant({.textures = textures, .own = own});
  variant.defines.emplace_back("QUADS", "1");
  return variant;
}

/// `indirect`: how many bakes of indirect light the picture lies between. `panes`: of KeptPanes.
ShaderVariant compose_variant(int stage, bool textures, std::size_t indirect, bool panes, bool glossy) {
  return {"shading/compose.comp",
          "",
          {{"STAGE", std::to_string(stage)},
           {"TEXTURES", flag(textures)},
           {"INDIRECT", std::to_string(indirect)},
           {"PANES", flag(panes)},
           {"GLOSSY", flag(glossy)}}};
}

ShaderVariant listed(ShaderVariant compose) {
  compose.defines.emplace_back("QUADS", "1");
  return compose;
}

ShaderVariant sky_variant(bool panes) { return {"shading/sky.comp", "", {{"PANES", flag(panes)}}}; }

ShaderVariant indirect_variant_of(bool measured) {
  return {"shading/indirect.comp", "", {{"MEASURED", flag(measured)}}};
}

}  // namespace

ShaderVariant gather_variant(bool accumulate, bool textures) {
  return {"shading/gather.comp", "", {{"ACCUMULATE", flag(accumulate)}, {"TEXTURES", flag(textures)}}};
}

ShaderVariant shade_variant(const FramePlan& plan, int measured) {
  ShaderVariant variant{
      "shading/shade.comp",
      "",
      {{"MEASURED", flag(measured)}, {"VISIBILITY", visibility_define(plan)}, {"LIGHTS", flag(plan.lights)}}};
  if (!measured && !plan.sheen) variant.defines.emplace_back("ANALYTIC_SHEEN", "0");
  if (!measured && !plan.clearcoat) variant.defines.emplace_back("ANALYTIC_COAT", "0");
  return variant;
}

std::vector<ShaderVariant> all_shader_variants() {
  std::vector<ShaderVariant> variants;
  for (int k = 0; k < 2; ++k) {
    variants.push_back({"gbuffer/visibility.frag", "gbuffer/visibility.vert", {{"ALPHA_MASK", flag(k)}}});
    for (const FillStep step : {FillStep::once, FillStep::find, FillStep::kept})
      for (int j = 0; j < 6; ++j)
        if (step != FillStep::find || (k == 0 && (j & 1) == 0))
          for (const bool middle : {false, true})
            variants.push_back(fill_variant({.textures = k == 1,
                                             .own = (j & 1) != 0,
                                             .cubic = j / 2 > 0,
                                             .tiles = j / 2 < 2,
                                             .step = step,
                                             .middle = middle}));
    for (int j = 0; j < 12; ++j)
      for (const bool glossy : {false, true})
        for (const int stage : {k, 2 * k + 1}) {
          const ShaderVariant variant =
              compose_variant(stage, j & 1, static_cast<std::size_t>(j / 2 % 3), j / 6 == 1, glossy);
          variants.push_back(stage == k ? variant : listed(variant));
        }
    variants.push_back(sky_variant(k));
    for (const bool own : {false, true}) variants.push_back(fill_quads_variant(k, own));
    for (int j = 0; j < 6; ++j) {
      FramePlan plan;
      plan.visibility = j < 2 ? "none" : j < 4 ? "baked" : "traced";
      plan.lights = j & 1;
      plan.texture_bandwidth = j & 1;
      for (const bool sky_variance : {false, true}) variants.push_back(predict_variant(plan, k, sky_variance));
      for (int lobes = 0; lobes < (k == 0 ? 4 : 1); ++lobes) {
        plan.sheen = lobes & 1;
        plan.clearcoat = lobes & 2;
        variants.push_back(shade_variant(plan, k));
        for (int turned = 0; turned < 4; ++turned)
          variants.push_back(scheduled_shade_variant(plan, k, turned & 1, turned & 2));
        variants.push_back(sun_variant(plan, k));
      }
      plan.visibility = k ? "baked" : "none";
      plan.lights = false;
      for (const bool coarse : {false, true})
        for (const bool first_only : {false, true})
          if (j < 2) variants.push_back(bandwidth_variant(plan, first_only, coarse));
    }
    variants.push_back(mark_variant(k, false, false, false, false));
    variants.push_back(mark_variant(true, false, false, k, true));
    variants.push_back(mark_variant(true, true, k, false, false));
    for (int j = 0; j < 2; ++j) variants.push_back(gather_variant(k, j));
    variants.push_back(indirect_variant_of(k));
    variants.push_back(classify_variant(k));
  }
  for (int k = 0; k < 8; ++k) {
    if ((k & 2) && !(k & 1)) continue;  // texture bandwidth without textures
    variants.push_back(resolve_variant(k & 1, k & 2, k & 4));
  }
  for (const int side : {1, 2, 4}) variants.push_back(present_variant(side));
  for (const char* path :
       {"gbuffer/tiles.comp", "gbuffer/curvature.comp", "bandwidth/pyramid.comp", "bandwidth/measure.comp",
        "bandwidth/worth.comp", "bandwidth/forget.comp", "bandwidth/quads.comp", "gbuffer/repainted.comp",
        "glass/tiles.comp", "octree/trace_rays.comp", "shading/arguments.comp", "shading/slots.comp",
        "splitsum/shade.comp", "sg/shade.comp"})
    variants.push_back({path, "", {}});
  variants.push_back(kOpen);
  variants.push_back(compose_variant(2, false, 0, false, false));
  variants.push_back(listed(compose_variant(4, false, 0, false, false)));
  variants.push_back(mark_variant(true, false, false, true, false));
  for (const std::vector<ShaderVariant>& more :
       {glass_shader_variants(), reflection_shader_variants(), turning_shader_variants()})
    variants.insert(variants.end(), more.begin(), more.end());
  return variants;
}

void Renderer::Impl::predict(const FramePlan& plan, const PredictedPart& part, PassTimer* timer) {
  FrameTargets& t = *targets;
  const int qw = t.energy.width(), qh = t.energy.height();
  if (has_near_terms(plan)) {
    if (!near_terms) near_terms = Texture::make_2d("near terms", GL_RGBA32F, qw, qh);
    glBindImageTexture(2, near_terms.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glBindTextureUnit(0, t.triangle.get());
    glBindTextureUnit(28, near_terms.get());
  }
  glBindImageTexture(0, t.energy.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  t.counters.clear_to_zero();
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, t.counters.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, t.items[0].get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, t.items[1].get());
  const bool first_only = t.side > 1;
  dispatch_tiles(programs.get(classify_variant(first_only)), part.tiles, first_only ? 0 : 2, {}, part.share);
  dispatch(programs.get({"shading/arguments.comp", "", {}}), 1, 1);
  glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, t.counters.get());
  for (int list = 0; list < 2; ++list) {
    if ((list == 0 ? facts.measured_count : facts.analytic_count) == 0) continue;
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, t.items[list].get());
    const Program& program = programs.get(predict_variant(plan, list == 0 ? 1 : 0, part.sky_variance));
    program.set("u_list", list);
    if (plan.visibility == "traced") octree.buffers().set_uniforms(program);
    glUseProgram(program.get());
    glDispatchComputeIndirect(list * 32 + 8);
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
  }
  timer->end("bandwidth");
  glBindTextureUnit(18, t.energy.get());
  if (plan.texture_bandwidth) glBindTextureUnit(20, t.texture_nu.get());
  glBindTextureUnit(31, t.bend.get());
  glBindImageTexture(0, t.pyramid.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(1, t.axes.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA16F);
  const bool coarse = t.whole_blocks();
  if (coarse) glBindImageTexture(2, t.pyramid.get(), 1, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  dispatch_tiles(programs.get(bandwidth_variant(plan, first_only, coarse)), part.tiles, 2, {}, part.share);
  timer->end("bandwidth");
  const Program& pyramid = programs.get({"bandwidth/pyramid.comp", "", {}});
  glBindTextureUnit(21, t.pyramid.get());
  int w = qw, h = qh;
  for (int level = 0; w > 1 || h > 1; ++level) {
    w = std::max(1, w / 2);
    h = std::max(1, h / 2);
    if (level == 0 && coarse) continue;
    pyramid.set("u_level", level);
    glBindImageTexture(0, t.pyramid.get(), level + 1, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    dispatch(pyramid, groups(w, 8), groups(h, 8));
  }
  glBindTextureUnit(21, t.pyramid.get());
  timer->end("pyramid");
}

void Renderer::Impl::bind_lists() {
  for (GLuint k = 0; k < 2; ++k) {
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2 + 2 * k, targets->items[k].get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3 + 2 * k, targets->points[k].get());
  }
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, targets->counters.get());
}

void Renderer::Impl::find_open(const FramePlan& plan, bool repaints) {
  if (plan.visibility != "baked") {
    open_found = false;
    return;
  }
  const FrameTargets& t = *targets;
  if (!open_found || repaints) {
    glBindTextureUnit(0, t.triangle.get());
    glBindImageTexture(0, t.open.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R8);
    dispatch_tiles(programs.get(kOpen), open_found ? t.repainted_tiles : t.surface_tiles, 6);
    open_found = true;
  }
  glBindTextureUnit(65, t.open.get());
}

void Renderer::Impl::shade(const FramePlan& plan, int chunk, const MarkRule& rule, PassTimer* timer) {
  shaded_points = shading_samples = 0;
  if (!rule.repainted) visible_points = 0;
  if (plan.mode == "bandwidth" && !rule.refine) find_open(plan, rule.repainted);
  for (std::size_t band = 0; band < targets->surface_tiles.counts.size(); ++band)
    shade_band(plan, band, chunk, rule, timer);
}

void Renderer::Impl::shade_band(const FramePlan& plan, std::size_t band, int chunk, const MarkRule& rule,
                                PassTimer* timer) {
  FrameTargets& t = *targets;
  bind_lists();
  const bool bandwidth = plan.mode == "bandwidth";
  const std::optional<RefineRates>& refine = rule.refine;
  const Program& mark = programs.get(mark_variant(bandwidth, refine.has_value(), refine && buffers->has_textures(),
                                                  rule.repainted, plan.visibility == "baked"));
  const TileList& tiles = rule.repainted ? t.repainted_tiles : t.surface_tiles;
  glBindImageTexture(0, t.marks.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA8UI);
  const bool accumulate = bandwidth && progressive;
  if (bandwidth) {
    mark.set("u_scouts", accumulate ? scout_share() : 0.0f);
    glBindTextureUnit(20, t.axes.get());
  }
  if (refine) {
    glBindImageTexture(1, t.radiance.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    mark.set("u_items_per_deviation", refine->items_per_deviation);
    mark.set("u_least_deviation", refine->least_deviation);
  }
  unsigned counters[16];
  // Counts average to the base count over the picture; a band that needs far more than its share gets what fits.
  for (float scale = 1.0f; scale > 1e-3f;) {
    t.counters.clear_to_zero();
    mark.set("u_item_capacity", t.item_capacity);
    mark.set("u_sample_scale", scale);
    dispatch_tiles(mark, tiles, 2, band);
    t.counters.read(0, sizeof(counters), counters);
    const auto most = static_cast<unsigned>(t.most_items);
    const unsigned wanted = std::max(counters[0], counters[8]);
    if (wanted > (refine ? std::min(most, refine->most_items) : most))
      scale *= 0.5f;
    else if (t.grow_lists(wanted))
      bind_lists();
    else
      break;
  }
  timer->end("mark");
  if (!rule.repainted) visible_points += counters[6];
  shaded_points += counters[1] + counters[9];
  shading_samples += (static_cast<std::size_t>(counters[0]) + counters[8]) * static_cast<std::size_t>(chunk);
  const Program& arguments = programs.get({"shading/arguments.comp", "", {}});
  dispatch(arguments, 1, 1);
  glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, t.counters.get());
  const Program& gather = programs.get(gather_variant(accumulate, bandwidth && buffers->has_textures()));
  if (accumulate) {
    glBindImageTexture(1, progressive->mean.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
    glBindImageTexture(2, progressive->spread.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_R32F);
  }
  glBindImageTexture(0, t.radiance.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  shade_lists(plan, counters, shade_variant, gather);
  timer->end("shade");
}

void Renderer::Impl::shade_lists(const FramePlan& plan, const unsigned* counters,
                                 ShaderVariant (*variant)(const FramePlan&, int), const Program& gather) {
  const FrameTargets& t = *targets;
  for (int list = 0; list < 2; ++list) {
    if (counters[8 * list] == 0) continue;
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, t.items[list].get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, t.partial[list].get());
    const Program& program = programs.get(variant(plan, list == 0 ? 1 : 0));
    program.set("u_list", list);
    if (plan.visibility == "traced") octree.buffers().set_uniforms(program);
    glUseProgram(program.get());
    glDispatchComputeIndirect(list * 32 + 8);
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, t.points[list].get());
    glBindTextureUnit(22, t.partial_view[list].get());
    gather.set("u_list", list);
    dispatch(gather, 256, 1);
  }
}

void Renderer::Impl::list_quads() {
  FrameTargets& t = *targets;
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, t.quad_counts.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, t.plain_quads.quads.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, t.mixed_quads.quads.get());
  t.quad_counts.clear_to_zero();
  dispatch_tiles(programs.get({"bandwidth/quads.comp", "", {}}), t.surface_tiles, 2);
  unsigned counts[2];
  t.quad_counts.read(0, sizeof counts, counts);
  t.plain_quads.count = static_cast<int>(counts[0]);
  t.mixed_quads.count = static_cast<int>(counts[1]);
}

void Renderer::Impl::dispatch_quads(const Program& program, const QuadList& list, int lanes) {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, list.quads.get());
  program.set("u_quads", list.count);
  dispatch_list(program, lanes * list.count);
}

void Renderer::Impl::fill(bool own, const TileList& tiles, PassTimer* timer) {
  FrameTargets& t = *targets;
  glBindTextureUnit(21, t.axes.get());
  glBindTextureUnit(23, t.marks.get());
  glBindImageTexture(0, t.radiance.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  glBindImageTexture(2, t.weights.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RG32UI);
  if (own) {
    glBindTextureUnit(18, progressive->mean.get());
    glBindTextureUnit(19, progressive->deviation.get());
    glBindTextureUnit(56, progressive->worth.get());
    glBindImageTexture(1, progressive->residual.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
  }
  const int levels = constants.size.w;
  const auto over_points = [&](FillStep step) {
    for (int level = levels - 1; level >= (t.side > 1 ? 1 : 0); --level) {
      const bool by_tiles = level <= kLastTileLevel, find = step == FillStep::find;
      const int side = 1 << level;
      for (int middle = 0; middle < 2; ++middle) {
        const Program& program = programs.get(fill_variant({.textures = !find && buffers->has_textures(),
                                                            .own = !find && own,
                                                            .cubic = level > 0,
                                                            .tiles = by_tiles,
                                                            .step = step,
                                                            .middle = middle == 1}));
        program.set("u_level", level);
        const int cells = groups(t.grid_width(), 2 * side) * groups(t.grid_height(), 2 * side);
        if (by_tiles)
          dispatch_tiles(program, find ? t.surface_tiles : tiles, 2 * (2 - level) + 1 - middle);
        else
          dispatch_list(program, middle ? cells : 2 * cells);
      }
    }
  };
  // From the second frame on that shows the same surfaces.
  if (keeps_surfaces && weights_levels != levels) {
    over_points(FillStep::find);
    weights_levels = levels;
  }
  over_points(keeps_surfaces ? FillStep::kept : FillStep::once);
  if (t.side > 1) {
    list_quads();
    const Program& program = programs.get(fill_quads_variant(buffers->has_textures(), own));
    program.set("u_level", 0);
    dispatch_quads(program, t.mixed_quads, 1);
  }
  timer->end("upsample");
}

void Renderer::Impl::bind_indirect(const Program& program, const IndirectKey& key) const {
  program.set("u_bias", key.bias);
  program.set("u_back", key.sides == 2 ? static_cast<int>(buffers->geometry().positions.size()) : 0);
  glBindTextureUnit(45, key.view.get());
}

void Renderer::Impl::add_indirect(const TileList& tiles, PassTimer* timer) {
  FrameTargets& t = *targets;
  for (const IndirectKey& key : indirect.keys()) {
    const std::size_t k = key.serial & 1u;
    if (!t.indirect[k]) {
      t.indirect[k] = Texture::make_2d("indirect light", GL_RGBA32F, t.grid_width(), t.grid_height());
      indirect_drawn[k].reset();
    }
    const IndirectDrawn drawn{points_epoch(), paint_news, key.serial};
    if (indirect_drawn[k] == drawn) continue;
    const bool but_for_paint =
        indirect_drawn[k] && indirect_drawn[k]->epoch == drawn.epoch && indirect_drawn[k]->serial == drawn.serial;
    indirect_drawn[k] = drawn;
    const Program& program = programs.get(indirect_variant_of(facts.measured_count > 0));
    bind_indirect(program, key);
    glBindTextureUnit(0, t.triangle.get());
    glBindImageTexture(0, t.indirect[k].get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    dispatch_tiles(program, but_for_paint ? tiles : t.surface_tiles, 6);
    timer->end("indirect");
  }
}

void Renderer::Impl::draw_sky(const FramePlan& plan, const FrameRequest& request, bool panes) {
  FrameTargets& t = *targets;
  const SkyKey key{request.env_rotation_rad, request.env_scale, composes_in_picture};
  if (!plan.glass && drawn_sky == key) return;
  drawn_sky.reset();
  if (!plan.glass) drawn_sky = key;  // panes are drawn over the very points
  glBindImageTexture(0, under_panes().get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  const Program& program = programs.get(sky_variant(panes));
  if (panes) bind_kept_panes(program, request.env_rotation_rad);
  dispatch_tiles(program, t.sky_tiles, 6);
}

const Texture& Renderer::Impl::under_panes() const {
  return composes_in_picture ? targets->picture : targets->radiance;
}

void Renderer::Impl::compose(const FramePlan& plan, const FrameRequest& request, float blend, PassTimer* timer) {
  FrameTargets& t = *targets;
  points_hold_mean = blend >= 1.0f;
  composes_in_picture = t.side == 1 && (!plan.glass || blend >= 1.0f);
  const bool kept = keep_panes(plan, request);
  draw_sky(plan, request, kept);
  const std::size_t keys = plan.indirect == "baked" ? indirect.keys().size() : 0;
  const bool bandwidth = plan.mode == "bandwidth";
  const auto program_of = [&](int stage, bool quads, bool panes) -> const Program& {
    const ShaderVariant variant =
        compose_variant(stage, bandwidth && buffers->has_textures(), keys, panes, plan.glossy);
    const Program& program = programs.get(quads ? listed(variant) : variant);
    if (panes) bind_kept_panes(program, request.env_rotation_rad);
    if (keys == 2) program.set("u_later", indirect.blend());
    return program;
  };
  if (composes_in_picture) glBindTextureUnit(24, t.radiance.get());
  for (std::size_t k = 0; k < keys; ++k)
    glBindTextureUnit(static_cast<GLuint>(18 + k), t.indirect[indirect.keys()[k].serial & 1u].get());
  if (plan.glossy) glBindTextureUnit(54, glossy_light.get());
  glBindImageTexture(0, under_panes().get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  if (bandwidth && t.side > 1) {
    const Program& plain = program_of(3, true, kept);
    plain.set("u_least_points", keys > 0 || plan.glossy || kept || buffers->has_colors() ? 4 : 1);
    dispatch_quads(plain, t.plain_quads, 1);
    dispatch_quads(program_of(1, true, kept), t.mixed_quads, 4);
    dispatch_quads(programs.get(listed(compose_variant(4, false, 0, false, false))), t.plain_quads, 1);
  } else {
    const auto complete = [&](const TileList& tiles, bool panes) {
      const Program& program = program_of(composes_in_picture ? 0 : 1, false, panes);
      if (composes_in_picture) program.set("u_blend", blend);
      dispatch_tiles(program, tiles, 6);
    };
    complete(kept ? kept_panes->bare_tiles : t.surface_tiles, false);
    if (kept) complete(kept_panes->covered_tiles, true);
  }
  timer->end("compose");
  if (plan.glass && !kept) {
    if (!plan.reflections.empty()) reflect(plan, request, timer);
    raster_glass(plan, request, glass_items(), false);
    timer->end("glass");
  }
  if (composes_in_picture) return;
  const Program& filter = programs.get(compose_variant(2, false, 0, false, false));
  filter.set("u_blend", blend);
  glBindTextureUnit(24, t.radiance.get());
  glBindImageTexture(0, t.picture.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  dispatch(filter, groups(t.width, 8), groups(t.height, 8));
  timer->end("compose");
}

}  // namespace maquette
