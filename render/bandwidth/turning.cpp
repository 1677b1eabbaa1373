// Frames while only the light turns, mode `bandwidth`: the prediction is renewed for a part of the picture, and every
// point's mean goes on by what its samples changed.
#include "render/bandwidth/turning.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "render/renderer_impl.h"

namespace maquette {

namespace {

/// The prediction is renewed once in so many frames at most, and before the light has turned so far: bandwidth changes
/// as slowly as the light.
constexpr int kPredictionFrames = 8;
constexpr float kPredictionHolds_rad = 0.3f;

/// A frame's lists are made once more where they cost so much more than their budget, and the frame after may ask for
/// so much more: points gain as many samples as going on takes.
constexpr float kFarTooMuch = 0.75f, kMostGrowth = 1.25f;

/// Samples of the sun at a point that does not mirror it: of one, over which broad lobes hardly vary, and of several,
/// among which they choose.
constexpr int kSunSamples = 2, kSunsSamples = 16;

ShaderVariant turned_mark_variant(bool masks) {
  return {"bandwidth/mark.comp",
          "",
          {{"BANDWIDTH", "1"}, {"REFINE", "0"}, {"TEXTURES", "0"}, {"VISIBILITY", flag(masks)}, {"MARKS_ONLY", "1"}}};
}
const ShaderVariant kSchedule{"turning/schedule.comp", "", {}};

ShaderVariant turned_gather_variant(int round, bool textures, bool sun) {
  return {"turning/gather.comp",
          "",
          {{"MORE", std::to_string(round)}, {"TEXTURES", flag(textures)}, {"SUN_APART", flag(sun)}}};
}

void set_sun(const Program& program, const SunBuffers& sun) {
  const auto inverse = [](double integral) { return integral > 0.0 ? static_cast<float>(1.0 / integral) : 0.0f; };
  glProgramUniform3f(program.get(), program.location("u_sun"), sun.least_luminance, inverse(sun.sun_sr),
                     inverse(sun.rest_integral));
}

/// As in shaders/turning/item.glsl.
struct TurnCounters {
  unsigned continued, small_items[2], large_items[2];
};
int least_item_log2(int item_samples) {
  return std::max(static_cast<int>(std::bit_width(static_cast<unsigned>(item_samples))) - 4, 1);
}

}  // namespace

TurnHistory TurnHistory::make(int grid_width, int grid_height) {
  TurnHistory h;
  h.mean = Texture::make_2d("history mean", GL_RGBA32F, grid_width, grid_height);
  h.renewed = Texture::make_2d("history renewed", GL_R32UI, grid_width, grid_height);
  h.sun = Texture::make_2d("sun at points", GL_RGBA32F, grid_width, grid_height);
  const GLuint never[4] = {};
  glClearTexImage(h.renewed.get(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, never);
  h.counters = Buffer("turning counters", sizeof(TurnCounters));
  return h;
}

float budgeted_scale(float scale, const TurnCost& cost, int base_count, int fewest) {
  const double spent = cost.samples + (kLookingBack - 1.0) * cost.looking_back;
  const double budget = cost.points * std::max(kTurningBudget * static_cast<float>(base_count),
                                               kGoingOnBudget * kLookingBack * static_cast<float>(fewest));
  const double wanted = spent > 0.0 ? scale * budget / spent : 1.0;
  return static_cast<float>(std::clamp(wanted, static_cast<double>(kLeastSampleScale), 1.0));
}

Turn Renderer::Impl::begin_turn(const FrameRequest& request, const FramePlan& plan, bool keeps, bool accumulate) {
  if (!keeps) {
    history.reset();
    drawn_light.reset();
    return {};
  }
  DrawnLight::Key key{request, epoch - indirect_news, plan.visibility, plan.lights};
  key.request.env_rotation_rad = 0.0f;
  key.request.deadline.reset();
  Turn turn;
  if (!accumulate && drawn_light && drawn_light->key == key)
    turn.angle_rad =
        std::remainder(request.env_rotation_rad - drawn_light->rotation_rad, 2.0f * std::numbers::pi_v<float>);
  turn.begins = turn.goes_on() && !drawn_light->scheduled;
  drawn_light = DrawnLight{std::move(key), request.env_rotation_rad, turn.goes_on()};
  if (accumulate) {
    history.reset();
    return turn;
  }
  if (!history || history->mean.width() != targets->grid_width() || history->mean.height() != targets->grid_height())
    history = TurnHistory::make(targets->grid_width(), targets->grid_height());
  // A number is left out when nothing goes on, so that no point looks renewed in the frame before.
  history->frame += turn.goes_on() && !turn.begins ? 1 : 2;
  turn.frame = history->frame;
  return turn;
}

TileShare renewed_share(const Turn& turn) {
  if (!turn.goes_on() || turn.begins) return {};
  const int frames =
      std::clamp(static_cast<int>(kPredictionHolds_rad / std::abs(turn.angle_rad)), 1, kPredictionFrames);
  return {static_cast<int>(turn.frame) % frames, frames};
}

ShaderVariant scheduled_shade_variant(const FramePlan& plan, bool measured, bool looks_back, bool sun) {
  ShaderVariant variant = shade_variant(plan, measured);
  variant.defines.emplace_back("TURNED", "1");
  variant.defines.emplace_back("LOOKS_BACK", flag(looks_back));
  variant.defines.emplace_back("SUN_APART", flag(sun));
  return variant;
}

ShaderVariant sun_variant(const FramePlan& plan, bool measured) {
  ShaderVariant variant = shade_variant(plan, measured);
  variant.path = "turning/sun.comp";
  variant.defines.emplace_back("SUN_APART", "1");
  return variant;
}

std::vector<ShaderVariant> turning_shader_variants() {
  std::vector<ShaderVariant> variants{turned_mark_variant(false), turned_mark_variant(true), kSchedule};
  for (int k = 0; k < 8; ++k) variants.push_back(turned_gather_variant(k / 4, k & 2, k & 1));
  return variants;
}

void Renderer::Impl::schedule_band(const FramePlan& plan, std::size_t band, const Turn& turn, unsigned* counters) {
  FrameTargets& t = *targets;
  bind_lists();
  const Program& mark = programs.get(turned_mark_variant(plan.visibility == "baked"));
  mark.set("u_item_capacity", t.item_capacity);
  mark.set("u_sample_scale", 1.0f);
  t.counters.clear_to_zero();
  glBindImageTexture(0, t.marks.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8UI);
  glBindTextureUnit(20, t.axes.get());
  dispatch_tiles(mark, t.surface_tiles, 2, band, renewed_share(turn));
  const Program& schedule = programs.get(kSchedule);
  glBindImageTexture(0, t.marks.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA8UI);
  glBindTextureUnit(18, history->mean.get());
  glBindTextureUnit(19, history->renewed.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 6, history->counters.get());
  schedule.set("u_turn_rad", std::abs(turn.angle_rad));
  schedule.set("u_frame_number", static_cast<int>(turn.frame));
  // A band that needs far more than its share gets what fits; what costs far more than its budget is asked for anew.
  bool asked_anew = false;
  for (float scale = history->sample_scale; scale > 1e-3f;) {
    t.counters.clear_to_zero();
    history->counters.clear_to_zero();
    schedule.set("u_item_capacity", t.item_capacity);
    schedule.set("u_sample_scale", scale);
    dispatch_tiles(schedule, t.surface_tiles, 2, band);
    t.counters.read(0, 16 * sizeof(unsigned), counters);
    TurnCounters listed;
    history->counters.read(0, sizeof listed, &listed);
    sample_scale = scale;
    const int fewest = 1 << least_item_log2(constants.sampling.y);
    const TurnCost cost{static_cast<double>(counters[1]) + counters[9], static_cast<double>(counters[5]) + counters[13],
                        fewest * (static_cast<double>(listed.small_items[0]) + listed.small_items[1])};
    const float next = budgeted_scale(scale, cost, constants.sampling.x, fewest);
    history->sample_scale = std::min(next, scale * kMostGrowth);
    const unsigned wanted = std::max(counters[0], counters[8]);
    if (wanted > static_cast<unsigned>(t.most_items)) {
      scale *= 0.5f;
    } else if (t.grow_lists(wanted)) {
      bind_lists();
    } else if (next < kFarTooMuch * scale && !asked_anew) {
      asked_anew = true;
      scale = next;
    } else {
      break;
    }
  }
}

void Renderer::Impl::shade_items(const FramePlan& plan, int list, const Turn& turn, bool looks_back, unsigned first,
                                 unsigned count) {
  if (count == 0) return;
  const FrameTargets& t = *targets;
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, t.items[list].get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 3, t.partial[list].get());
  const SunBuffers* sun = environment->sun();
  const Program& program = programs.get(scheduled_shade_variant(plan, list == 0, looks_back, sun != nullptr));
  if (sun) set_sun(program, *sun);
  glProgramUniform2i(program.get(), program.location("u_range"), static_cast<GLint>(first), static_cast<GLint>(count));
  if (looks_back)
    glProgramUniform2f(program.get(), program.location("u_turn"), std::cos(turn.angle_rad), std::sin(turn.angle_rad));
  if (plan.visibility == "traced") octree.buffers().set_uniforms(program);
  dispatch_list(program, static_cast<int>(count));
}

void Renderer::Impl::shade_sun(const FramePlan& plan, int list, const Turn& turn, unsigned points) {
  const SunBuffers* sun = environment->sun();
  if (!sun || points == 0) return;
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, targets->points[list].get());
  glBindImageTexture(0, history->sun.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  const Program& program = programs.get(sun_variant(plan, list == 0));
  set_sun(program, *sun);
  program.set("u_frame_number", static_cast<int>(turn.frame));
  glProgramUniform3i(program.get(), program.location("u_range"), static_cast<GLint>(points), SunBuffers::kListLength,
                     sun->compact ? kSunSamples : kSunsSamples);
  if (plan.visibility == "traced") octree.buffers().set_uniforms(program);
  dispatch_list(program, static_cast<int>(points));
}

void Renderer::Impl::shade_scheduled_band(const FramePlan& plan, std::size_t band, const Turn& turn, PassTimer* timer) {
  FrameTargets& t = *targets;
  unsigned counters[16];
  schedule_band(plan, band, turn, counters);
  const auto capacity = static_cast<unsigned>(t.item_capacity);
  TurnCounters listed;
  history->counters.read(0, sizeof listed, &listed);
  continued_points += listed.continued;
  timer->end("mark");
  shaded_points += counters[1] + counters[9];
  const SunBuffers* sun = environment->sun();
  if (sun) sun->bind();
  for (int list = 0; list < 2; ++list) shade_sun(plan, list, turn, counters[8 * list + 1]);
  if (sun) glBindImageTexture(3, history->sun.get(), 0, GL_FALSE, 0, GL_READ_ONLY, GL_RGBA32F);
  glBindImageTexture(0, t.radiance.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(1, history->mean.get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA32F);
  glBindImageTexture(2, history->renewed.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32UI);
  for (int round = 0; round < 2; ++round) {
    const Program& gather = programs.get(turned_gather_variant(round, buffers->has_textures(), sun));
    gather.set("u_frame_number", static_cast<int>(turn.frame));
    gather.set("u_item_capacity", t.item_capacity);
    gather.set("u_sample_scale", sample_scale);
    gather.set("u_point_capacity", static_cast<int>(t.points[0].bytes() / 16));
    for (int list = 0; list < 2; ++list) {
      const unsigned more = std::min(counters[8 * list + 6], capacity), large = listed.large_items[list];
      if ((round == 0 ? counters[8 * list] : more) == 0) continue;
      shade_items(plan, list, turn, round == 0, 0, round == 0 ? listed.small_items[list] : more);
      if (round == 0) shade_items(plan, list, turn, false, capacity - large, large);
      glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, t.points[list].get());
      glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 4, t.items[list].get());  // the first round lists the second
      glBindTextureUnit(22, t.partial_view[list].get());
      gather.set("u_list", list);
      dispatch(gather, 256, 1);
      shading_samples += round == 0 ? counters[8 * list + 5] : more << (least_item_log2(constants.sampling.y) + 3);
    }
    timer->end("shade");
    t.counters.read(0, sizeof counters, counters);
  }
}

void Renderer::Impl::shade_scheduled(const FramePlan& plan, const Turn& turn, PassTimer* timer) {
  shaded_points = shading_samples = continued_points = 0;
  find_open(plan, false);
  for (std::size_t band = 0; band < targets->surface_tiles.counts.size(); ++band)
    shade_scheduled_band(plan, band, turn, timer);
  environment->bind();
}

}  // namespace maquette
