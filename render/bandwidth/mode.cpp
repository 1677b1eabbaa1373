#include "render/bandwidth/mode.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "render/bandwidth/accumulation.h"
#include "render/bandwidth/prediction.h"
#include "render/bandwidth/swapped_tables.h"
#include "render/bandwidth/temporal_reuse.h"
#include "render/bandwidth/upsampling.h"
#include "render/gl/bindings.h"
#include "render/views/read_texture.h"

namespace maquette {

namespace {

/// Frames in which all points are shaded at least once, needed or not; coarser levels are through sooner by four.
constexpr float kScoutFrames = 64.0f;

ShaderVariant mark_variant(bool refine, bool textures, bool swapped, bool visibility) {
  ShaderVariant variant{"bandwidth/mark.comp",
                        "",
                        {{"BANDWIDTH", "1"},
                         {"REFINE", flag(refine)},
                         {"TEXTURES", flag(textures)},
                         {"VISIBILITY", flag(visibility && !refine)}}};
  if (swapped) variant.defines.emplace_back("MATERIAL_REPLACED", "1");
  return variant;
}

/// Samples of a work item: a quarter of a point's, but no less than 64 while there are so many: an item costs as much
/// to begin as 5 to 10 samples. Error squared times time at 64 samples is 5 to 20 % less with items of 64 than of 16 in
/// six scenes of seven.
int samples_per_item(const FrameRequest& request) {
  constexpr int kLeast = 4, kEnough = 64;
  const int per_point = std::max(asked_samples(request, "bandwidth.samples") / std::max(request.msaa, 1), kLeast);
  const auto power_of_two = [](int n) { return static_cast<int>(std::bit_ceil(static_cast<unsigned>(n))); };
  return std::clamp(power_of_two(per_point / 4), std::min(power_of_two(per_point), kEnough), 4096);
}

class BandwidthMode : public ShadingMode {
 public:
  int band_rows(const GridSize& size) const override { return band_rows_of(size, true); }
  void fit(const GridSize& size) override;
  Continuation compare(const FrameChange& change) const override;
  void begin(const FrameStart& start, FrameStatus* status) override;
  void set_constants(const FrameStart& start, const ShadingPlan& plan, FrameConstants* constants) const override;
  void prepare(const FrameStart& start, const LayerContext& layer) override;
  std::vector<Pass> passes(const LayerContext& layer) override;
  const TileList* changed_tiles() const override { return repaints_ ? &swapped_.tiles() : nullptr; }
  void end(const FrameStart& start) override { drawn_points_ = start.points; }
  void shade_hits(const HitShading& hits) override { sampled_.shade_hits(hits); }
  ShadingCounts counts() const override { return sampled_.counts; }
  ComposeInfo compose_info(const SceneState& scene) const override {
    const bool several = size_.side > 1;
    return {scene.buffers().has_textures(), several ? &upsampling_.plain_quads() : nullptr,
            several ? &upsampling_.mixed_quads() : nullptr};
  }
  void add_bytes(std::map<std::string, std::size_t>* bytes) const override;
  void add_counters(std::map<std::string, double>* counters) const override {
    if (rotation_) (*counters)["continued_points"] = static_cast<double>(reuse_.reused_points());
  }
  std::optional<PointValue> view(const std::string& name, const LayerContext& layer) const override;

 private:
  const TileList& tiles(const LayerContext& layer) const {
    return repaints_ ? swapped_.tiles() : layer.surfaces.tiles();
  }
  void measure(const LayerContext& layer);
  void shade(const LayerContext& layer);
  void shade_band(const LayerContext& layer, std::size_t band);
  /// Density of points, over that of other frames, where what is drawn stands for an instant only.
  std::optional<float> passing_density(const ShadingPlan& plan) const;

  GridSize size_;
  SampledShading sampled_;
  Prediction prediction_;
  Upsampling upsampling_;
  TemporalReuse reuse_;
  SwappedTables swapped_;
  std::optional<Accumulation> accumulation_;  ///< while pictures accumulate
  std::optional<Key> drawn_points_;           ///< that the radiance holds points of; empty: nothing to keep
  // Of the frame at hand:
  bool accumulate_ = false, repaints_ = false, goes_on_ = false;
  int frame_ = 0;  ///< frames in the picture before it
  LightRotation rotation_;
  std::optional<RefineRates> rates_;
  std::uint32_t seed_ = 0;
};

void BandwidthMode::fit(const GridSize& size) {
  size_ = size;
  sampled_.fit(size, true);
  prediction_.fit(size);
  upsampling_.fit(size);
  reuse_.clear();
  accumulation_.reset();
  drawn_points_.reset();
}

Continuation BandwidthMode::compare(const FrameChange& change) const {
  // Several points a pixel are filtered in place: nothing of them is left.
  const bool keeps = size_.side == 1 && change.request.settings.get_bool("shading.reuse") && !change.nothing_moved &&
                     drawn_points_ == change.points && change.same_request && (!change.accumulate || accumulation_);
  // A frame that was not to be accumulated kept nothing to go on from.
  return {accumulation_.has_value(), keeps};
}

void BandwidthMode::begin(const FrameStart& start, FrameStatus* status) {
  drawn_points_.reset();  // until the frame is there
  accumulate_ = start.accumulate;
  repaints_ = start.repaints;
  frame_ = start.accumulated;
  goes_on_ = start.accumulated > 0;
  seed_ = start.request.seed;
  rates_.reset();
  if (start.request.settings.get_bool("shading.reuse")) {
    rotation_ = reuse_.begin(start, Key::of(start.points, start.scene.revisions().tables), size_);
  } else {
    reuse_.clear();
    rotation_ = {};
  }
  status->light_rotated = static_cast<bool>(rotation_);
}

std::optional<float> BandwidthMode::passing_density(const ShadingPlan& plan) const {
  if (rotation_) return plan.visibility == "baked" ? kReuseShadowedDensity : kReuseDensity;
  if (repaints_) return kReuseDensity;
  return std::nullopt;
}

void BandwidthMode::set_constants(const FrameStart& start, const ShadingPlan& plan, FrameConstants* c) const {
  const std::optional<float> density = passing_density(plan);
  int samples = asked_samples(start.request, "bandwidth.samples");
  if (density) samples = std::max(static_cast<int>(kReuseSamples * static_cast<float>(samples)), 1);
  c->size.w = start.request.settings.get_int("bandwidth.max_level") + (size_.side == 4 ? 2 : size_.side / 2);
  // Each point counts its own samples.
  c->sampling = glm::ivec4(samples, samples_per_item(start.request), 0, static_cast<int>(start.request.seed));
  // Interpolation's error falls with the square of the spacing, and noise with the 0.8th power of the samples (docs/
  // numerics/bandwidth.md): so they fall together. Once there is a picture, what was measured decides instead.
  c->quality.x = static_cast<float>(start.request.settings.get_double("bandwidth.quality")) *
                 std::pow(static_cast<float>(samples) / 64.0f, 0.4f) * density.value_or(1.0f);
}

void BandwidthMode::prepare(const FrameStart& start, const LayerContext& layer) {
  const int levels = layer.constants.size.w;
  const bool textures = layer.frame.scene.buffers().has_textures();
  if (repaints_) {
    if (!accumulate_) accumulation_.reset();
  } else if (start.accumulated == 0) {
    if (!accumulate_)
      accumulation_.reset();
    else if (accumulation_ && accumulation_->levels() == levels && accumulation_->textures() == textures)
      accumulation_->clear();
    else
      accumulation_.emplace(size_, layer.surfaces.tiles().tiles.bytes() / sizeof(unsigned), levels, textures);
  }
}

std::vector<Pass> BandwidthMode::passes(const LayerContext& layer) {
  ProgramCache* programs = &layer.frame.programs;
  const auto known = [this] { return goes_on_ ? std::string("nothing moved: known from the first frame") : ""; };
  const auto pass = [&](std::vector<std::string> names, std::function<void()> run) {
    return Pass{.names = std::move(names), .layer = layer.index, .run = std::move(run)};
  };
  std::vector<Pass> passes;
  passes.push_back(pass({"curvature"}, [this, &layer] { prediction_.find_curvature(layer); }));
  passes.back().key = [&layer] { return Key::of(layer.surfaces.revision()); };
  passes.push_back(pass({"replaced_materials"}, [this, &layer] {
    swapped_.find(layer);
    if (accumulation_) accumulation_->forget(swapped_.tiles(), &layer.frame.programs);
  }));
  passes.push_back(pass({"bandwidth"}, [this, &layer] {
    const bool apart = layer.plan.sun_apart || (rotation_ && layer.frame.scene.environment().sun());
    prediction_.predict(layer, {tiles(layer), renewed_share(rotation_), apart}, &sampled_.lists());
  }));
  passes.back().skip = known;
  passes.push_back(pass({"pyramid"}, [this, programs] { prediction_.make_pyramid(programs); }));
  passes.back().skip = known;
  passes.push_back(pass({"measure"}, [this, &layer] { measure(layer); }));
  passes.push_back(pass({"mark", "shade"}, [this, &layer] { shade(layer); }));
  passes.push_back(pass({"upsample"}, [this, &layer] {
    std::function<void()> bind_own;
    if (accumulation_) bind_own = [this] { accumulation_->bind_for_filling(); };
    upsampling_.fill(layer, prediction_.axes(), sampled_.marks(), bind_own, tiles(layer), layer.constants.size.w);
  }));
  return passes;
}

void BandwidthMode::measure(const LayerContext& layer) {
  rates_ = accumulation_->measure(layer, prediction_.pyramid(), sampled_.marks(), sampled_.counts.visible);
  if (accumulation_->needs_new_light_samples(rates_->light_rounds))
    layer.frame.light_samples.renew(&layer.frame.scene.environment(), seed_, frame_);
}

void BandwidthMode::shade(const LayerContext& layer) {
  if (rotation_) {
    prediction_.find_sky_visibility(layer, nullptr);
    reuse_.shade(layer, rotation_, prediction_.axes(), &sampled_);
    return;
  }
  sampled_.counts.shaded = sampled_.counts.samples = 0;
  if (!repaints_) sampled_.counts.visible = 0;
  if (!rates_) prediction_.find_sky_visibility(layer, repaints_ ? &swapped_.tiles() : nullptr);
  for (std::size_t band = 0; band < layer.surfaces.tiles().counts.size(); ++band) shade_band(layer, band);
}

void BandwidthMode::shade_band(const LayerContext& layer, std::size_t band) {
  ProgramCache& programs = layer.frame.programs;
  const bool textures = layer.frame.scene.buffers().has_textures();
  const Program& mark =
      programs.get(mark_variant(rates_.has_value(), rates_ && textures, repaints_, layer.plan.visibility == "baked"));
  sampled_.lists().bind();
  glBindImageTexture(kImageMarks, sampled_.marks().get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA8UI);
  mark.set("u_early_share", accumulation_ ? static_cast<float>(frame_ + 1) / kScoutFrames : 0.0f);
  glBindTextureUnit(kUnitAxes, prediction_.axes().get());
  if (rates_) {
    accumulation_->bind_for_marking();
    glBindImageTexture(kImageMarkedRadiance, layer.radiance.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    mark.set("u_items_per_deviation", rates_->items_per_deviation);
    mark.set("u_least_deviation", rates_->least_deviation);
  }
  unsigned counters[16];
  sampled_.mark_band({mark, tiles(layer), rates_ ? rates_->most_items : ~0u}, band, counters);
  layer.frame.timer().end("mark");
  if (!repaints_) sampled_.counts.visible += counters[6];
  sampled_.counts.shaded += counters[1] + counters[9];
  sampled_.counts.samples +=
      (static_cast<std::size_t>(counters[0]) + counters[8]) * static_cast<std::size_t>(layer.constants.sampling.y);
  count_groups(sampled_.lists(), &programs);
  const Program& gather = programs.get(gather_variant(accumulation_.has_value(), textures));
  if (accumulation_) accumulation_->bind_for_gathering();
  glBindImageTexture(kImageRadiance, layer.radiance.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  sampled_.shade_lists(layer.frame, layer.plan, counters, shade_variant, gather);
  layer.frame.timer().end("shade");
}

void BandwidthMode::add_bytes(std::map<std::string, std::size_t>* bytes) const {
  (*bytes)["shading"] += sampled_.bytes();
  (*bytes)["bandwidth"] += prediction_.bytes() + upsampling_.bytes();
  if (accumulation_) (*bytes)["accumulation"] += accumulation_->bytes();
  if (reuse_.has_history()) (*bytes)["accumulation"] += reuse_.bytes();
}

std::optional<PointValue> BandwidthMode::view(const std::string& name, const LayerContext& layer) const {
  if (auto value = view_of_marks(name, sampled_.marks())) return value;
  if (name != "borrowed") return prediction_.view(name);
  const auto marks = read_texture<std::uint8_t>(sampled_.marks(), GL_RGBA_INTEGER, GL_UNSIGNED_BYTE, 4);
  std::vector<float> shares;
  if (accumulation_)
    shares = accumulation_->borrowed_shares(marks, layer.constants.sampling.y);
  else
    for (std::size_t i = 0; i < marks.size(); i += 4) shares.push_back(marks[i] != 0 ? 0.0f : 1.0f);
  return [w = size_.grid_width(), shares = std::move(shares)](int x, int y) {
    return glm::vec3(shares[static_cast<std::size_t>(y * w + x)]);
  };
}

}  // namespace

std::unique_ptr<ShadingMode> make_bandwidth_mode() { return std::make_unique<BandwidthMode>(); }

std::vector<DebugViewInfo> bandwidth_views() {
  return {{"borrowed"},          {"bandwidth"},         {"variance"},       {"curvature"},
          {"angular_bandwidth"}, {"footprint_stretch"}, {"footprint_angle"}};
}

std::vector<ShaderVariant> bandwidth_shader_variants() {
  std::vector<ShaderVariant> variants{gather_variant(false, true), gather_variant(true, false),
                                      gather_variant(true, true), mark_variant(false, false, true, false),
                                      mark_variant(false, false, true, true)};
  for (const bool k : {false, true}) {
    variants.push_back(mark_variant(false, false, false, k));
    variants.push_back(mark_variant(true, k, false, false));
  }
  for (const auto& more :
       {SampledShading::shader_variants(), Prediction::shader_variants(), Upsampling::shader_variants(),
        Accumulation::shader_variants(), TemporalReuse::shader_variants(), SwappedTables::shader_variants()})
    variants.insert(variants.end(), more.begin(), more.end());
  return variants;
}

}  // namespace maquette
