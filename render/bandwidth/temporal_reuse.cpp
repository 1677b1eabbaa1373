// Frames while only the environment rotates, mode `bandwidth`: the prediction is renewed for a part of the picture, and
// every point's mean is corrected by what its samples changed.
#include "render/bandwidth/temporal_reuse.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "render/bake/scene_bakes.h"
#include "render/gl/bindings.h"

namespace maquette {

namespace {

/// The prediction is renewed once in so many frames at most, and before the light has rotated so far: bandwidth changes
/// as slowly as the light.
constexpr int kPredictionFrames = 8;
constexpr float kPredictionHolds_rad = 0.3f;

/// A frame's lists are made once more where they cost so much more than their budget, and the frame after may ask for
/// so much more: points gain as many samples as reuse takes.
constexpr float kFarTooMuch = 0.75f, kMostGrowth = 1.25f;

/// Samples of the sun at a point that does not mirror it: of one, over which broad lobes hardly vary, and of several,
/// among which they choose.
constexpr int kSunSamples = 2, kSunsSamples = 16;

ShaderVariant mark_variant(bool visibility) {
  return {
      "bandwidth/mark.comp",
      "",
      {{"BANDWIDTH", "1"}, {"REFINE", "0"}, {"TEXTURES", "0"}, {"VISIBILITY", flag(visibility)}, {"MARKS_ONLY", "1"}}};
}
const ShaderVariant kSchedule{"rotation/schedule.comp", "", {}};

ShaderVariant gather_variant_of(int round, bool textures, bool sun) {
  return {"rotation/gather.comp",
          "",
          {{"MORE", std::to_string(round)}, {"TEXTURES", flag(textures)}, {"SEPARATE_SUN", flag(sun)}}};
}

/// As in shaders/rotation/item.glsl.
struct ReuseCounters {
  unsigned continued, small_items[2], large_items[2];
};
int least_item_log2(int item_samples) {
  return std::max(static_cast<int>(std::bit_width(static_cast<unsigned>(item_samples))) - 4, 1);
}

}  // namespace

TemporalReuse::History::History(int grid_width, int grid_height)
    : mean(Texture::make_2d("history mean", GL_RGBA32F, grid_width, grid_height)),
      renewed(Texture::make_2d("history renewed", GL_R32UI, grid_width, grid_height)),
      sun(Texture::make_2d("sun at points", GL_RGBA32F, grid_width, grid_height)),
      counters("reuse counters", sizeof(ReuseCounters)) {
  const GLuint never[4] = {};
  glClearTexImage(renewed.get(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, never);
}

float budgeted_scale(float scale, const ReuseCost& cost, int base_count, int fewest) {
  const double spent = cost.samples + (kLookingBack - 1.0) * cost.looking_back;
  const double budget = cost.points * std::max(kReuseBudget * static_cast<float>(base_count),
                                               kLookingBackBudget * kLookingBack * static_cast<float>(fewest));
  const double wanted = spent > 0.0 ? scale * budget / spent : 1.0;
  return static_cast<float>(std::clamp(wanted, static_cast<double>(kLeastSampleScale), 1.0));
}

void TemporalReuse::clear() {
  history_.reset();
  drawn_.reset();
}

LightRotation TemporalReuse::begin(const FrameStart& start, const Key& points, const GridSize& size) {
  DrawnLight light{start.request, points, start.request.env_rotation_rad, false};
  light.request.env_rotation_rad = 0.0f;
  light.request.deadline.reset();
  LightRotation rotation;
  if (!start.accumulate && drawn_ && drawn_->request == light.request && drawn_->points == light.points)
    rotation.angle_rad = std::remainder(light.rotation_rad - drawn_->rotation_rad, 2.0f * std::numbers::pi_v<float>);
  rotation.begins = rotation && !drawn_->reused;
  light.reused = static_cast<bool>(rotation);
  drawn_ = std::move(light);
  if (start.accumulate) {
    history_.reset();
    return rotation;
  }
  if (!history_ || history_->mean.width() != size.grid_width() || history_->mean.height() != size.grid_height())
    history_.emplace(size.grid_width(), size.grid_height());
  // A number is left out when nothing is reused, so that no point looks renewed in the frame before.
  history_->frame += rotation && !rotation.begins ? 1 : 2;
  rotation.frame = history_->frame;
  return rotation;
}

TileShare renewed_share(const LightRotation& rotation) {
  if (!rotation || rotation.begins) return {};
  const int frames =
      std::clamp(static_cast<int>(kPredictionHolds_rad / std::abs(rotation.angle_rad)), 1, kPredictionFrames);
  return {static_cast<int>(rotation.frame) % frames, frames};
}

namespace {

/// Of the points that shaders/rotation/schedule.comp lists; `reuses_history`: they may be reused.
ShaderVariant scheduled_shade_variant(ShadingPlan plan, bool measured, bool reuses_history, bool sun) {
  plan.sun_apart = false;  // said below
  ShaderVariant variant = shade_variant(plan, measured);
  variant.defines.emplace_back("ROTATING", "1");
  variant.defines.emplace_back("REUSES_HISTORY", flag(reuses_history));
  variant.defines.emplace_back("SEPARATE_SUN", flag(sun));
  return variant;
}

/// Of rotation/sun.comp.
ShaderVariant sun_variant(ShadingPlan plan, bool measured) {
  plan.sun_apart = false;
  ShaderVariant variant = shade_variant(plan, measured);
  variant.path = "rotation/sun.comp";
  variant.defines.emplace_back("SEPARATE_SUN", "1");
  return variant;
}

}  // namespace

std::vector<ShaderVariant> TemporalReuse::shader_variants() {
  std::vector<ShaderVariant> variants{mark_variant(false), mark_variant(true), kSchedule};
  for (int k = 0; k < 8; ++k) variants.push_back(gather_variant_of(k / 4, k & 2, k & 1));
  for (const char* visibility : {"none", "baked", "traced"})
    for (int k = 0; k < 4; ++k)
      for (int lobes = 0; lobes < (k & 2 ? 1 : 4); ++lobes) {
        ShadingPlan plan;
        plan.visibility = visibility;
        plan.lights = k & 1;
        plan.sheen = lobes & 1;
        plan.clearcoat = lobes & 2;
        for (int reused = 0; reused < 4; ++reused)
          variants.push_back(scheduled_shade_variant(plan, k & 2, reused & 1, reused & 2));
        variants.push_back(sun_variant(plan, k & 2));
      }
  return variants;
}

void TemporalReuse::schedule(Band* band) {
  const LayerContext& layer = band->layer;
  WorkLists& lists = band->sampled.lists();
  const Texture& marks = band->sampled.marks();
  const TileList& tiles = layer.surfaces.tiles();
  unsigned* counters = band->counters;
  lists.bind();
  const Program& mark = layer.frame.programs.get(mark_variant(layer.plan.visibility == "baked"));
  mark.set("u_item_capacity", lists.capacity);
  mark.set("u_sample_scale", 1.0f);
  lists.counters.clear_to_zero();
  glBindImageTexture(kImageMarks, marks.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8UI);
  glBindTextureUnit(kUnitAxes, band->axes.get());
  dispatch_tiles(mark, tiles, kPerBlock, band->number, renewed_share(band->rotation));
  const Program& schedule = layer.frame.programs.get(kSchedule);
  glBindImageTexture(kImageMarks, marks.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA8UI);
  glBindTextureUnit(kUnitHistory, history_->mean.get());
  glBindTextureUnit(kUnitRenewed, history_->renewed.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferTemporalCounters, history_->counters.get());
  schedule.set("u_rotation_rad", std::abs(band->rotation.angle_rad));
  schedule.set("u_frame_number", static_cast<int>(band->rotation.frame));
  // A band that needs far more than its share gets what fits; what costs far more than its budget is asked for anew.
  const glm::ivec4 sampling = layer.constants.sampling;
  bool asked_anew = false;
  for (float scale = history_->sample_scale; scale > 1e-3f;) {
    lists.counters.clear_to_zero();
    history_->counters.clear_to_zero();
    schedule.set("u_item_capacity", lists.capacity);
    schedule.set("u_sample_scale", scale);
    dispatch_tiles(schedule, tiles, kPerBlock, band->number);
    lists.counters.read(0, sizeof band->counters, counters);
    ReuseCounters listed;
    history_->counters.read(0, sizeof listed, &listed);
    sample_scale_ = scale;
    const int fewest = 1 << least_item_log2(sampling.y);
    const ReuseCost cost{static_cast<double>(counters[1]) + counters[9],
                         static_cast<double>(counters[5]) + counters[13],
                         fewest * (static_cast<double>(listed.small_items[0]) + listed.small_items[1])};
    const float next = budgeted_scale(scale, cost, sampling.x, fewest);
    history_->sample_scale = std::min(next, scale * kMostGrowth);
    const unsigned wanted = std::max(counters[0], counters[8]);
    if (wanted > static_cast<unsigned>(lists.most)) {
      scale *= 0.5f;
    } else if (lists.grow(wanted)) {
      lists.bind();
    } else if (next < kFarTooMuch * scale && !asked_anew) {
      asked_anew = true;
      scale = next;
    } else {
      break;
    }
  }
}

void TemporalReuse::shade_items(const Band& band, int list, bool reuses_history, unsigned first, unsigned count) {
  if (count == 0) return;
  const LayerContext& layer = band.layer;
  const WorkLists& lists = band.sampled.lists();
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferItems, lists.items[list].get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferPartial, lists.partial[list].get());
  const SunBuffers* sun = layer.frame.scene.environment().sun();
  const Program& program =
      layer.frame.programs.get(scheduled_shade_variant(layer.plan, list == 0, reuses_history, sun != nullptr));
  if (sun) set_sun(program, *sun);
  glProgramUniform2i(program.get(), program.location("u_range"), static_cast<GLint>(first), static_cast<GLint>(count));
  const float angle = band.rotation.angle_rad;
  if (reuses_history)
    glProgramUniform2f(program.get(), program.location("u_rotation"), std::cos(angle), std::sin(angle));
  if (layer.plan.visibility == "traced") layer.frame.bakes.octree().buffers().set_uniforms(program);
  dispatch_list(program, static_cast<int>(count));
}

void TemporalReuse::shade_sun(const Band& band, int list, unsigned points) {
  const LayerContext& layer = band.layer;
  const SunBuffers* sun = layer.frame.scene.environment().sun();
  if (!sun || points == 0) return;
  if (layer.plan.sun_apart) {  // shadow rays bring its light
    const float none[4] = {};
    glClearTexImage(history_->sun.get(), 0, GL_RGBA, GL_FLOAT, none);
    return;
  }
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferPoints, band.sampled.lists().points[list].get());
  glBindImageTexture(kImageSun, history_->sun.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  const Program& program = layer.frame.programs.get(sun_variant(layer.plan, list == 0));
  set_sun(program, *sun);
  program.set("u_frame_number", static_cast<int>(band.rotation.frame));
  glProgramUniform3i(program.get(), program.location("u_range"), static_cast<GLint>(points), SunBuffers::kListLength,
                     sun->compact ? kSunSamples : kSunsSamples);
  if (layer.plan.visibility == "traced") layer.frame.bakes.octree().buffers().set_uniforms(program);
  dispatch_list(program, static_cast<int>(points));
}

void TemporalReuse::shade_round(Band* band, int round, const unsigned large_items[2], const unsigned small_items[2]) {
  const LayerContext& layer = band->layer;
  SampledShading& sampled = band->sampled;
  const WorkLists& lists = sampled.lists();
  const auto capacity = static_cast<unsigned>(lists.capacity);
  const SunBuffers* sun = layer.frame.scene.environment().sun();
  const Program& gather =
      layer.frame.programs.get(gather_variant_of(round, layer.frame.scene.buffers().has_textures(), sun));
  gather.set("u_frame_number", static_cast<int>(band->rotation.frame));
  gather.set("u_item_capacity", lists.capacity);
  gather.set("u_sample_scale", sample_scale_);
  gather.set("u_point_capacity", static_cast<int>(lists.points[0].bytes() / 16));
  for (int list = 0; list < 2; ++list) {
    const unsigned* counters = band->counters + 8 * list;
    const unsigned more = std::min(counters[6], capacity), large = large_items[list];
    if ((round == 0 ? counters[0] : more) == 0) continue;
    shade_items(*band, list, round == 0, 0, round == 0 ? small_items[list] : more);
    if (round == 0) shade_items(*band, list, false, capacity - large, large);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferPoints, lists.points[list].get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferNextItems,
                     lists.items[list].get());  // the first round lists the second
    glBindTextureUnit(kUnitPartial, lists.partial_view[list].get());
    gather.set("u_list", list);
    dispatch(gather, 256, 1);
    sampled.counts.samples += round == 0 ? counters[5] : more << (least_item_log2(layer.constants.sampling.y) + 3);
  }
}

void TemporalReuse::shade_band(Band* band) {
  const LayerContext& layer = band->layer;
  SampledShading& sampled = band->sampled;
  schedule(band);
  ReuseCounters listed;
  history_->counters.read(0, sizeof listed, &listed);
  reused_points_ += listed.continued;
  layer.frame.timer().end("mark");
  sampled.counts.shaded += band->counters[1] + band->counters[9];
  const SunBuffers* sun = layer.frame.scene.environment().sun();
  if (sun) sun->bind();
  for (int list = 0; list < 2; ++list) shade_sun(*band, list, band->counters[8 * list + 1]);
  if (sun) glBindImageTexture(kImageGatheredSun, history_->sun.get(), 0, GL_FALSE, 0, GL_READ_ONLY, GL_RGBA32F);
  glBindImageTexture(kImageRadiance, layer.radiance.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(kImageHistory, history_->mean.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  glBindImageTexture(kImageRenewed, history_->renewed.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32UI);
  for (int round = 0; round < 2; ++round) {
    shade_round(band, round, listed.large_items, listed.small_items);
    layer.frame.timer().end("shade");
    sampled.lists().counters.read(0, sizeof band->counters, band->counters);
  }
}

void TemporalReuse::shade(const LayerContext& layer, const LightRotation& rotation, const Texture& axes,
                          SampledShading* sampled) {
  sampled->counts.shaded = sampled->counts.samples = reused_points_ = 0;
  for (std::size_t number = 0; number < layer.surfaces.tiles().counts.size(); ++number) {
    Band band{layer, rotation, axes, *sampled, number};
    shade_band(&band);
  }
  layer.frame.scene.environment().bind();
}

}  // namespace maquette
