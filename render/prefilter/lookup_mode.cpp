#include "render/prefilter/lookup_mode.h"

#include <algorithm>
#include <utility>

#include "render/frame/vocabulary.h"
#include "render/gl/bindings.h"

namespace maquette {

namespace {

/// Of the environment, for cells with BRDFs: a mode without noise shows none there.
constexpr int kSamplesOfCells = 64;

class LookupMode : public ShadingMode {
 public:
  using Maker = std::function<std::unique_ptr<LookupTables>(const Environment&)>;
  LookupMode(std::string shader, Maker make) : shader_(std::move(shader)), make_(std::move(make)) {}

  int band_rows(const GridSize& size) const override { return band_rows_of(size, false); }
  void fit(const GridSize& size) override {
    marks_ = Texture::make_2d("marks", GL_RGBA8UI, size.grid_width(), size.grid_height());
  }
  bool keeps_tables() const override { return tables_ != nullptr; }
  void set_constants(const FrameStart& start, const ShadingPlan&, FrameConstants* constants) const override {
    const int samples = std::max(start.request.samples, 1);
    constants->sampling = {samples, std::max(samples, 2), start.accumulated * samples,
                           static_cast<int>(start.request.seed)};
  }
  std::vector<Pass> passes(const LayerContext& layer) override {
    return {{.names = {"prefilter"},
             .layer = layer.index,
             .skip = [this, &layer] { return is_current(layer) ? std::string("its tables are those of before") : ""; },
             .run = [this, &layer] { prefilter(layer); }},
            {.names = {"shade"}, .layer = layer.index, .run = [this, &layer] { shade(layer); }}};
  }
  void shade_hits(const HitShading& hits) override {
    const ReflectionTargets& t = hits.targets;
    tables_->bind();
    run({shader_, "", {{"REFLECTED", "1"}}}, t.radiance, t.marks, t.tiles, hits.frame.programs);
  }
  int samples_of_cells() const override { return kSamplesOfCells; }
  ShadingCounts counts() const override { return counts_; }
  void add_bytes(std::map<std::string, std::size_t>* bytes) const override {
    if (tables_) (*bytes)["prefilter"] += tables_->bytes();
    (*bytes)["shading"] += marks_.bytes();
  }

 private:
  bool is_current(const LayerContext& layer) const {
    const SceneState& scene = layer.frame.scene;
    return tables_ && sky_ == scene.revisions().sky && material_count_ == scene.materials().count();
  }
  void prefilter(const LayerContext& layer) {
    SceneState& scene = layer.frame.scene;
    if (!tables_ || sky_ != scene.revisions().sky) tables_ = make_(scene.environment().environment());
    sky_ = scene.revisions().sky;
    material_count_ = scene.materials().count();
    tables_->update(scene.materials());
  }
  void run(const ShaderVariant& variant, const Texture& radiance, const Texture& marks, const TileList& tiles,
           ProgramCache& programs) {
    counters_.clear_to_zero();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferCounters, counters_.get());
    glBindImageTexture(kImageRadiance, radiance.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glBindImageTexture(kImageLookupMarks, marks.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8UI);
    dispatch_tiles(programs.get(variant), tiles, kPerFourPoints);
  }
  void shade(const LayerContext& layer) {
    tables_->bind();
    run({shader_, "", {}}, layer.radiance, marks_, layer.surfaces.tiles(), layer.frame.programs);
    unsigned counts[2] = {};
    counters_.read(0, sizeof counts, counts);
    counts_ = {counts[0], counts[1], 0};
  }

  std::string shader_;
  Maker make_;
  std::unique_ptr<LookupTables> tables_;
  std::uint32_t sky_ = 0;  ///< revision that they are of
  std::size_t material_count_ = 0;
  Texture marks_;
  Buffer counters_ = Buffer("lookup counters", 2 * sizeof(unsigned));
  ShadingCounts counts_;
};

}  // namespace

std::unique_ptr<ShadingMode> make_lookup_mode(const std::string& shader,
                                              std::function<std::unique_ptr<LookupTables>(const Environment&)> make) {
  return std::make_unique<LookupMode>(shader, std::move(make));
}

std::vector<ShaderVariant> lookup_shader_variants(const std::string& shader) {
  return {{shader, "", {}}, {shader, "", {{"REFLECTED", "1"}}}};
}

Technique lookup_technique(const std::string& name, const std::string& help, const std::string& filtered) {
  Technique technique;
  technique.name = name;
  technique.help = help;
  technique.check = [](const SceneFacts&, const Settings& settings) -> std::optional<std::string> {
    const std::string& asked = settings.get_string("shading.visibility");
    if (asked == "baked" || asked == "rays")
      return "a mode that looks up prefiltered maps knows no visibility (shading.visibility=" + asked +
             "); use one that takes samples";
    return std::nullopt;
  };
  technique.add_passes = [filtered](const PlanInput&, ShadingPlan* shading, FramePlan* plan) {
    plan->passes.push_back({"prefilter", "the environment filtered for each " + filtered + ", once", {}, {"maps"}});
    plan->passes.push_back({"shade", "every visible pixel, by lookups", {"surfaces", "maps"}, {"radiance"}});
    plan->left_out.push_back({words::kBandwidth, "mode " + shading->mode + " predicts nothing"});
  };
  technique.words = {{Word::Kind::pass, "prefilter", "the environment filtered for the lobes that are looked up"}};
  return technique;
}

}  // namespace maquette
