#include "render/uniform/mode.h"

#include <algorithm>

#include "render/gl/bindings.h"
#include "render/shading/sampled_shading.h"

namespace maquette {

namespace {

const ShaderVariant kMark{
    "bandwidth/mark.comp", "", {{"BANDWIDTH", "0"}, {"REFINE", "0"}, {"TEXTURES", "0"}, {"VISIBILITY", "0"}}};

class UniformMode : public ShadingMode {
 public:
  int band_rows(const GridSize& size) const override { return band_rows_of(size, false); }
  void fit(const GridSize& size) override { sampled_.fit(size, false); }
  void set_constants(const FrameStart& start, const ShadingPlan&, FrameConstants* constants) const override {
    const int samples = asked_samples(start.request, "uniform.samples");
    constants->sampling = {samples, std::max(samples, 2), start.accumulated * samples,
                           static_cast<int>(start.request.seed)};
  }
  void begin(const FrameStart& start, FrameStatus*) override {
    // A list of light samples is used up after so many frames.
    samples_ = asked_samples(start.request, "uniform.samples");
  }
  void prepare(const FrameStart& start, const LayerContext& layer) override {
    layer.frame.light_samples.renew_for(&layer.frame.scene.environment(), start.request.seed, start.accumulated,
                                        static_cast<std::int64_t>(start.accumulated) * samples_, samples_);
  }
  std::vector<Pass> passes(const LayerContext& layer) override {
    return {{.names = {"mark", "shade"}, .layer = layer.index, .run = [this, &layer] { shade(layer); }}};
  }
  void shade_hits(const HitShading& hits) override { sampled_.shade_hits(hits); }
  ShadingCounts counts() const override { return sampled_.counts; }
  void add_bytes(std::map<std::string, std::size_t>* bytes) const override { (*bytes)["shading"] += sampled_.bytes(); }
  std::optional<PointValue> view(const std::string& name, const LayerContext&) const override {
    return view_of_marks(name, sampled_.marks());
  }

 private:
  void shade(const LayerContext& layer) {
    ProgramCache& programs = layer.frame.programs;
    sampled_.counts = {};
    for (std::size_t band = 0; band < layer.surfaces.tiles().counts.size(); ++band) {
      unsigned counters[16];
      glBindImageTexture(kImageMarks, sampled_.marks().get(), 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA8UI);
      sampled_.mark_band({programs.get(kMark), layer.surfaces.tiles(), ~0u}, band, counters);
      layer.frame.timer().end("mark");
      sampled_.counts.visible += counters[6];
      sampled_.counts.shaded += counters[1] + counters[9];
      sampled_.counts.samples +=
          (static_cast<std::size_t>(counters[0]) + counters[8]) * static_cast<std::size_t>(layer.constants.sampling.y);
      count_groups(sampled_.lists(), &programs);
      glBindImageTexture(kImageRadiance, layer.radiance.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
      sampled_.shade_lists(layer.frame, layer.plan, counters, shade_variant,
                           programs.get(gather_variant(false, false)));
      layer.frame.timer().end("shade");
    }
  }

  SampledShading sampled_;
  int samples_ = 1;
};

}  // namespace

std::unique_ptr<ShadingMode> make_uniform_mode() { return std::make_unique<UniformMode>(); }

std::vector<ShaderVariant> uniform_shader_variants() {
  std::vector<ShaderVariant> variants = SampledShading::shader_variants();
  variants.push_back(kMark);
  return variants;
}

}  // namespace maquette
