#include "render/slf/mode.h"

#include <array>

#include "render/gl/bindings.h"
#include "render/picture/tonemap.h"
#include "render/shading/work_lists.h"
#include "render/views/read_texture.h"

namespace maquette {

namespace {

constexpr const char *kShade = "slf/shade.comp", *kView = "slf/view.comp";
constexpr std::array<const char*, 6> kViews{"slf_texels", "slf_charts",  "slf_clusters",
                                            "slf_errors", "slf_weights", "slf_slice"};
constexpr std::size_t kSlice = 5;

ShaderVariant view_variant(std::size_t view) {
  ShaderVariant variant{kView, "", {}};
  if (view == kSlice) variant.defines.emplace_back("SLICE", "1");
  return variant;
}

/// Of the environment, for cells with BRDFs: a mode without noise shows none there.
constexpr int kSamplesOfCells = 64;

/// As bright as the sky on average.
float preview_cdm2(const FrameContext& frame) {
  const double sky = mean_luminance(*frame.scene.environment().shared_environment());
  return sky > 0.0 ? static_cast<float>(sky) * frame.request.env_scale : 1.0f;
}

class LightFieldMode : public ShadingMode {
 public:
  int band_rows(const GridSize& size) const override { return band_rows_of(size, false); }
  void fit(const GridSize& size) override {
    marks_ = Texture::make_2d("marks", GL_RGBA8UI, size.grid_width(), size.grid_height());
  }
  void set_constants(const FrameStart& start, const ShadingPlan&, FrameConstants* constants) const override {
    constants->sampling = {1, 2, start.accumulated, static_cast<int>(start.request.seed)};
  }
  std::vector<Pass> passes(const LayerContext& layer) override {
    return {{.names = {"shade"}, .layer = layer.index, .run = [this, &layer] {
               run(layer.frame, layer.plan, {kShade, "", {}}, layer.radiance, marks_, layer.surfaces.tiles());
               unsigned counts[2] = {};
               counters_.read(0, sizeof counts, counts);
               counts_ = {counts[0], counts[1], 0};
             }}};
  }
  void shade_hits(const HitShading& hits) override {
    const ReflectionTargets& t = hits.targets;
    run(hits.frame, hits.plan, {kShade, "", {{"REFLECTED", "1"}}}, t.radiance, t.marks, t.tiles);
  }
  int samples_of_cells() const override { return kSamplesOfCells; }
  ShadingCounts counts() const override { return counts_; }
  void add_bytes(std::map<std::string, std::size_t>* bytes) const override { (*bytes)["shading"] += marks_.bytes(); }
  void add_counters(std::map<std::string, double>* counters) const override {
    (*counters)["slf_pixels"] = static_cast<double>(counts_.shaded);
    (*counters)["slf_pixels_without"] = static_cast<double>(counts_.visible - counts_.shaded);
  }
  std::optional<PointValue> view(const std::string& name, const LayerContext& layer) const override {
    for (std::size_t i = 0; i < kViews.size(); ++i)
      if (name == kViews[i]) return read_view(i, layer);
    return std::nullopt;
  }

 private:
  void run(const FrameContext& frame, const ShadingPlan& plan, const ShaderVariant& variant, const Texture& radiance,
           const Texture& marks, const TileList& tiles) {
    counters_.clear_to_zero();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferCounters, counters_.get());
    glBindImageTexture(kImageRadiance, radiance.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glBindImageTexture(kImageLookupMarks, marks.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8UI);
    ShaderVariant own = variant;
    const bool baked = !plan.own_bake.empty();
    own.defines.emplace_back("BAKED", flag(baked));
    const Program& program = frame.programs.get(own);
    if (!baked) program.set("u_preview_cdm2", preview_cdm2(frame));
    dispatch_tiles(program, tiles, kPerPoint);
  }
  PointValue read_view(std::size_t view, const LayerContext& layer) const {
    const GridSize& size = layer.surfaces.size();
    const Texture values = Texture::make_2d("view", GL_RGBA32F, size.grid_width(), size.grid_height());
    const float black[4] = {};
    glClearTexImage(values.get(), 0, GL_RGBA, GL_FLOAT, black);
    if (!layer.plan.own_bake.empty()) {
      layer.surfaces.bind();
      const Program& program = layer.frame.programs.get(view_variant(view));
      const auto angle = [&](const char* setting) {
        return glm::radians(static_cast<float>(layer.frame.request.settings.get_double(setting)));
      };
      if (view == kSlice) {
        program.set("u_slice_tilt", angle("slf.slice_tilt"));
        program.set("u_slice_turn", angle("slf.slice_turn"));
      } else {
        program.set("u_view", static_cast<int>(view));
      }
      glBindImageTexture(kImageRadiance, values.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
      dispatch_tiles(program, layer.surfaces.tiles(), kPerPoint);
    }
    return value_of_texels<float>(values, GL_RGBA, GL_FLOAT, 1,
                                  [](const float* v) { return glm::vec3(v[0], v[1], v[2]); });
  }

  Texture marks_;
  Buffer counters_ = Buffer("light field counters", 2 * sizeof(unsigned));
  ShadingCounts counts_;
};

}  // namespace

std::unique_ptr<ShadingMode> make_light_field_mode() { return std::make_unique<LightFieldMode>(); }

std::vector<ShaderVariant> light_field_shader_variants() {
  std::vector<ShaderVariant> variants{view_variant(0), view_variant(kSlice)};
  for (const bool baked : {false, true}) {
    variants.push_back({kShade, "", {{"BAKED", flag(baked)}}});
    variants.push_back({kShade, "", {{"REFLECTED", "1"}, {"BAKED", flag(baked)}}});
  }
  return variants;
}

}  // namespace maquette
