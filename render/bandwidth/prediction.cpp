#include "render/bandwidth/prediction.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>

#include "render/bake/scene_bakes.h"
#include "render/gl/bindings.h"
#include "render/materials/bandwidth.h"
#include "render/math/shared_formulas.h"
#include "render/shading/sampled_shading.h"
#include "render/views/read_texture.h"

namespace maquette {

namespace {

constexpr int kPredictionSamples = 8;  // directions a quad; neighbours pool to about 50

ShaderVariant predict_variant(const ShadingPlan& plan, bool measured, bool sky_variance) {
  return {"bandwidth/predict.comp",
          "",
          {{"MEASURED", flag(measured)},
           {"SHADOWED", visibility_define(plan)},
           {"LIGHTS", flag(plan.lights)},
           {"SKY_VARIANCE", flag(sky_variance)},
           {"SEEN_BANDWIDTHS", std::to_string(kSeenBandwidthCount)},
           {"PREDICTION_SAMPLES", std::to_string(kPredictionSamples)}}};
}

bool has_near_terms(const ShadingPlan& plan) { return plan.visibility != "none" || plan.lights; }

/// `first_only`: predicts the first quad alone of every other block of 2 x 2, whatever it shows.
ShaderVariant classify_variant(bool first_only) {
  return {"bandwidth/classify.comp", "", {{"FIRST_ONLY", flag(first_only)}}};
}

/// `coarse`: makes the pyramid's next level as well, which takes whole blocks of 2 x 2 quads.
ShaderVariant bandwidth_variant(const ShadingPlan& plan, bool first_only, bool coarse) {
  return {"bandwidth/bandwidth.comp",
          "",
          {{"TEXTURE_BANDWIDTH", flag(plan.texture_bandwidth)},
           {"NEAR", flag(has_near_terms(plan))},
           {"COARSE", flag(coarse)},
           {"FIRST_ONLY", flag(first_only)},
           {"PREDICTION_SAMPLES", std::to_string(kPredictionSamples)}}};
}

const ShaderVariant kSkyVisibility{"bandwidth/sky_visibility.comp", "", {{"VISIBILITY", "1"}}};
const ShaderVariant kCurvature{"gbuffer/curvature.comp", "", {}}, kPyramid{"bandwidth/pyramid.comp", "", {}};

/// How far the footprint of a shaded point is longer than wide, and along which direction: degrees from 0 to 180 from
/// the screen's right towards its top; 0 where it is round. Arguments: of screen_bandwidth.
glm::vec2 footprint(float nu_x, float nu_y, float correlation) {
  const double x = nu_x, y = nu_y, cross = static_cast<double>(correlation) * x * y;
  const double middle = 0.5 * (x * x + y * y), spread = std::hypot(0.5 * (x * x - y * y), cross);
  if (middle <= 0.0) return {1.0f, 0.0f};
  constexpr double kLeast = 2.5e-4;  // of the wider axis, squared: the correlation is a half float
  const double stretch = std::sqrt((middle + spread) / std::max(middle - spread, kLeast * (middle + spread)));
  if (spread <= kLeast * middle) return {static_cast<float>(stretch), 0.0f};
  // Of the smaller eigenvalue; rows run downwards.
  const double angle = glm::degrees(0.5 * std::atan2(2.0 * cross, y * y - x * x));
  return {static_cast<float>(stretch), static_cast<float>(angle < 0.0 ? angle + 180.0 : angle)};
}

}  // namespace

std::vector<ShaderVariant> Prediction::shader_variants() {
  std::vector<ShaderVariant> variants{kSkyVisibility, kCurvature, kPyramid, classify_variant(false),
                                      classify_variant(true)};
  for (int k = 0; k < 2; ++k) {
    for (const char* visibility : {"none", "baked", "traced"})
      for (const bool lights : {false, true})
        for (const bool sky_variance : {false, true}) {
          ShadingPlan plan;
          plan.visibility = visibility;
          plan.lights = lights;
          variants.push_back(predict_variant(plan, k, sky_variance));
        }
    for (int j = 0; j < 8; ++j) {
      ShadingPlan plan;
      plan.visibility = k ? "baked" : "none";
      plan.texture_bandwidth = j & 1;
      variants.push_back(bandwidth_variant(plan, j & 2, j & 4));
    }
  }
  return variants;
}

void Prediction::fit(const GridSize& size) {
  size_ = size;
  const int w = size.grid_width(), h = size.grid_height(), qw = (w + 1) / 2, qh = (h + 1) / 2;
  energy_ = Texture::make_2d("energy", GL_RGBA32F, qw, qh);
  screen_curvature_ = Texture::make_2d("screen_curvature", GL_RGBA32UI, qw, qh);
  axes_ = Texture::make_2d("axes", GL_RGBA16F, qw, qh);
  const int levels = static_cast<int>(std::bit_width(static_cast<unsigned>(std::max(qw, qh))));
  pyramid_ = Texture::make_2d("pyramid", GL_RGBA32F, qw, qh, levels);
  sky_visibility_ = Texture::make_2d("open to mirrors", GL_R8, w, h);
  near_terms_ = Texture();
  open_of_.reset();
}

void Prediction::find_curvature(const LayerContext& layer) {
  const float none[4] = {};
  glClearTexImage(energy_.get(), 0, GL_RGBA, GL_FLOAT, none);
  glClearTexImage(pyramid_.get(), 0, GL_RGBA, GL_FLOAT, none);
  if (whole_blocks()) glClearTexImage(pyramid_.get(), 1, GL_RGBA, GL_FLOAT, none);
  glBindImageTexture(kImageScreenCurvature, screen_curvature_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32UI);
  dispatch_tiles(layer.frame.programs.get(kCurvature), layer.surfaces.tiles(), kPerQuad);
}

void Prediction::list_quads(const LayerContext& layer, const PredictedPart& part, WorkLists* lists) const {
  glBindImageTexture(kImageEnergy, energy_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  lists->counters.clear_to_zero();
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferCounters, lists->counters.get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferMeasuredPixels, lists->items[0].get());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferAnalyticPixels, lists->items[1].get());
  const bool first_only = size_.side > 1;
  dispatch_tiles(layer.frame.programs.get(classify_variant(first_only)), part.tiles, first_only ? kPerTile : kPerBlock,
                 {}, part.share);
  count_groups(*lists, &layer.frame.programs);
}

void Prediction::predict(const LayerContext& layer, const PredictedPart& part, WorkLists* lists) {
  const FrameContext& frame = layer.frame;
  ProgramCache& programs = frame.programs;
  if (has_near_terms(layer.plan)) {
    if (!near_terms_) near_terms_ = Texture::make_2d("near terms", GL_RGBA32F, energy_.width(), energy_.height());
    glBindImageTexture(kImageNear, near_terms_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glBindTextureUnit(kUnitTriangle, layer.surfaces.triangle().get());
    glBindTextureUnit(kUnitNear, near_terms_.get());
  }
  list_quads(layer, part, lists);
  const SceneFacts& facts = frame.scene.facts();
  for (int list = 0; list < 2; ++list) {
    if ((list == 0 ? facts.measured_count : facts.analytic_count) == 0) continue;
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferMeasuredPixels, lists->items[list].get());
    const Program& program = programs.get(predict_variant(layer.plan, list == 0, part.sky_variance));
    program.set("u_list", list);
    if (layer.plan.visibility == "traced") frame.bakes.octree().buffers().set_uniforms(program);
    dispatch_indirect(program, list * 32 + 8);
  }
  glBindTextureUnit(kUnitEnergy, energy_.get());
  if (layer.plan.texture_bandwidth)
    glBindTextureUnit(kUnitTextureBandwidthMap, layer.surfaces.texture_bandwidth().get());
  glBindTextureUnit(kUnitScreenCurvature, screen_curvature_.get());
  glBindImageTexture(kImageBandwidth, pyramid_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(kImageAxes, axes_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA16F);
  const bool coarse = whole_blocks();
  if (coarse) glBindImageTexture(kImageFirstCoarse, pyramid_.get(), 1, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  dispatch_tiles(programs.get(bandwidth_variant(layer.plan, size_.side > 1, coarse)), part.tiles, kPerBlock, {},
                 part.share);
}

void Prediction::make_pyramid(ProgramCache* programs) {
  const Program& program = programs->get(kPyramid);
  glBindTextureUnit(kUnitPyramid, pyramid_.get());
  int w = pyramid_.width(), h = pyramid_.height();
  for (int level = 0; w > 1 || h > 1; ++level) {
    w = std::max(1, w / 2);
    h = std::max(1, h / 2);
    if (level == 0 && whole_blocks()) continue;
    program.set("u_level", level);
    glBindImageTexture(kImageCoarse, pyramid_.get(), level + 1, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    dispatch(program, group_count(w, 8), group_count(h, 8));
  }
}

void Prediction::find_sky_visibility(const LayerContext& layer, const TileList* swapped) {
  if (layer.plan.visibility != "baked") {
    open_of_.reset();
    return;
  }
  const Key key = Key::of(layer.surfaces.revision(), layer.frame.bakes.visibility_revision());
  const std::uint32_t tables = layer.frame.scene.revisions().tables;
  const bool known = open_of_ == key && (swapped || open_tables_ == tables);
  if (!known || swapped) {
    glBindTextureUnit(kUnitTriangle, layer.surfaces.triangle().get());
    glBindImageTexture(kImageSkyVisibility, sky_visibility_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R8);
    dispatch_tiles(layer.frame.programs.get(kSkyVisibility), known ? *swapped : layer.surfaces.tiles(), kPerPoint);
    open_of_ = key;
    open_tables_ = tables;
  }
  glBindTextureUnit(kUnitSkyVisibility, sky_visibility_.get());
}

std::size_t Prediction::bytes() const {
  return energy_.bytes() + screen_curvature_.bytes() + axes_.bytes() + sky_visibility_.bytes() + pyramid_.bytes() +
         near_terms_.bytes();
}

std::optional<PointValue> Prediction::view(const std::string& name) const {
  if (name == "curvature")
    return value_of_texels<std::uint32_t>(
        screen_curvature_, GL_RGBA_INTEGER, GL_UNSIGNED_INT, 2, [](const std::uint32_t* q) {
          const shared::ScreenCurvature curvature = shared::unpack_screen_curvature({q[0], q[1], q[2], q[3]});
          return glm::vec3(std::max(curvature.turn.x / curvature.step_m.x, curvature.turn.y / curvature.step_m.y));
        });
  if (name == "footprint_stretch" || name == "footprint_angle")
    return value_of_texels<float>(axes_, GL_RGBA, GL_FLOAT, 2, [angle = name == "footprint_angle"](const float* q) {
      return glm::vec3(footprint(q[0], q[1], q[2])[angle ? 1 : 0]);
    });
  if (name == "angular_bandwidth")
    return value_of_texels<float>(axes_, GL_RGBA, GL_FLOAT, 2, [](const float* q) { return glm::vec3(q[3]); });
  if (name == "bandwidth")
    return value_of_texels<float>(pyramid_, GL_RGBA, GL_FLOAT, 2, [](const float* q) { return glm::vec3(q[0]); });
  if (name == "variance")
    return value_of_texels<float>(pyramid_, GL_RGBA, GL_FLOAT, 2,
                                  [](const float* q) { return glm::vec3(q[2] * q[2]); });
  return std::nullopt;
}

}  // namespace maquette
