#include "render/prt/mode.h"

#include <algorithm>
#include <array>

#include "render/bake/scene_bakes.h"
#include "render/gl/bindings.h"
#include "render/gl/dispatch.h"
#include "render/math/shared_formulas.h"
#include "render/prt/store.h"
#include "render/shading/work_lists.h"
#include "render/views/read_texture.h"

namespace maquette {

namespace {

constexpr const char *kVertices = "prt/vertices.comp", *kShade = "prt/shade.comp", *kView = "prt/view.comp";
/// In the order of u_view in prt/view.comp.
constexpr std::array<const char*, 5> kViews{"prt_vertices", "prt_clusters", "prt_light", "prt_component", "prt_error"};
/// Beside the picture's sky: on surfaces it is the view prt_light.
constexpr const char* kKeptView = "prt_kept";
/// Of the environment, for cells with BRDFs: a mode without noise shows none there.
constexpr int kSamplesOfCells = 64;

/// In the joint form the count of terms is no constant of the shaders.
ShaderDefines defines(int terms, bool joint) {
  return joint ? ShaderDefines{{"JOINT", "1"}} : ShaderDefines{{"TERMS", std::to_string(terms)}};
}
ShaderDefines defines(int terms, bool joint, bool baked) {
  ShaderDefines own = defines(terms, joint);
  own.emplace_back("BAKED", flag(baked));
  return own;
}
ShaderDefines defines(const TransferBuffers& buffers) { return defines(buffers.terms(), buffers.joint()); }

void set_counts(const Program& program, const TransferBuffers& buffers) {
  program.set("u_transfer_components", buffers.components());
  if (!buffers.joint()) return;
  program.set("u_transfer_functions", buffers.functions());
  program.set("u_transfer_view_rows", buffers.rows_of_view());
}

const TransferStore* find_store(const FrameContext& frame, const ShadingPlan& plan) {
  return plan.own_bake.empty() ? nullptr : dynamic_cast<const TransferStore*>(frame.bakes.own(plan.own_bake));
}

class TransferMode : public ShadingMode {
 public:
  int band_rows(const GridSize& size) const override { return band_rows_of(size, false); }
  void fit(const GridSize& size) override {
    marks_ = Texture::make_2d("marks", GL_RGBA8UI, size.grid_width(), size.grid_height());
  }
  void set_constants(const FrameStart& start, const ShadingPlan&, FrameConstants* constants) const override {
    constants->sampling = {1, 2, start.accumulated, static_cast<int>(start.request.seed)};
  }
  std::vector<Pass> passes(const LayerContext& layer) override {
    Pass vertices{.names = {"transfer_vertices"}, .layer = layer.index};
    vertices.key = [&layer] {
      return Key::of(layer.frame.request.camera, layer.frame.request.width, layer.frame.request.height,
                     layer.frame.bakes.without_indirect());
    };
    vertices.run = [&layer] { run_vertices(layer); };
    Pass shade{.names = {"shade"}, .layer = layer.index};
    shade.run = [this, &layer] {
      run_shade(layer.frame, layer.plan, {kShade, "", {}}, layer.radiance, marks_, layer.surfaces.tiles());
      unsigned counts[2] = {};
      counters_.read(0, sizeof counts, counts);
      counts_ = {counts[0], counts[1], 0};
      if (const TransferStore* store = find_store(layer.frame, layer.plan)) remember(*store);
    };
    return {vertices, shade};
  }
  void shade_hits(const HitShading& hits) override {
    const ReflectionTargets& t = hits.targets;
    run_shade(hits.frame, hits.plan, {kShade, "", {{"REFLECTED", "1"}}}, t.radiance, t.marks, t.tiles);
  }
  int samples_of_cells() const override { return kSamplesOfCells; }
  ShadingCounts counts() const override { return counts_; }
  void add_bytes(std::map<std::string, std::size_t>* bytes) const override { (*bytes)["shading"] += marks_.bytes(); }
  void add_counters(std::map<std::string, double>* counters) const override {
    for (const auto& [name, value] : remembered_) (*counters)[name] = value;
    (*counters)["prt_pixels_without"] = static_cast<double>(counts_.visible - counts_.shaded);
  }
  std::optional<PointValue> view(const std::string& name, const LayerContext& layer) const override {
    for (std::size_t i = 0; i < kViews.size(); ++i)
      if (name == kViews[i] || (name == kKeptView && kViews[i] == std::string("prt_light")))
        return read_view(static_cast<int>(i), layer);
    return std::nullopt;
  }
  PointValue sky_view(const std::string& name, const LayerContext& layer) const override {
    const TransferStore* store = name == kKeptView ? find_store(layer.frame, layer.plan) : nullptr;
    if (!store) return {};
    const FrameConstants& c = layer.constants;
    const GridSize& size = layer.surfaces.size();
    const glm::vec2 grid(size.grid_width(), size.grid_height());
    return [c, grid, sky = store->kept_sky(), scale = layer.frame.request.env_scale](int x, int y) {
      const glm::vec2 at = 2.0f * (glm::vec2(x, y) + 0.5f) / grid - 1.0f;
      const shared::EyeRay ray = shared::camera_ray(glm::vec3(c.forward), glm::vec3(c.right), glm::vec3(c.up), c.eye.w,
                                                    glm::vec2(at.x, -at.y));
      return scale * sky(glm::normalize(glm::dvec3(ray.direction)));
    };
  }

 private:
  static void run_vertices(const LayerContext& layer) {
    const TransferStore* store = find_store(layer.frame, layer.plan);
    if (!store || store->buffers().vertices() == 0) return;
    const Program& program = layer.frame.programs.get({kVertices, "", defines(store->buffers())});
    const TransferBuffers& buffers = store->buffers();
    set_counts(program, buffers);
    for (int first = 0; first < buffers.vertices(); first += buffers.vertices_at_once()) {
      const int count = std::min(buffers.vertices_at_once(), buffers.vertices() - first);
      program.set("u_first_vertex", first);
      program.set("u_vertices", first + count);
      buffers.bind_shown(first);
      dispatch_list(program, count);
    }
  }
  void run_shade(const FrameContext& frame, const ShadingPlan& plan, const ShaderVariant& variant,
                 const Texture& radiance, const Texture& marks, const TileList& tiles) {
    const TransferStore* store = find_store(frame, plan);
    counters_.clear_to_zero();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferCounters, counters_.get());
    glBindImageTexture(kImageRadiance, radiance.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
    glBindImageTexture(kImageLookupMarks, marks.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8UI);
    ShaderVariant own = variant;
    const ShaderDefines more = defines(store ? store->buffers().terms() : transfer_terms(0),
                                       store && store->buffers().joint(), store != nullptr);
    own.defines.insert(own.defines.end(), more.begin(), more.end());
    const Program& program = frame.programs.get(own);
    if (store) {
      set_counts(program, store->buffers());
      program.set("u_environment_scale", frame.request.env_scale);
    }
    dispatch_tiles(program, tiles, kPerPoint);
  }
  void remember(const TransferStore& store) {
    const Transfer& transfer = store.transfer();
    double bytes = 0.0;
    for (const TransferGroup& group : transfer.bake->groups)
      bytes += static_cast<double>(transfer.bake->bytes_per_vertex(group) * group.vertices.size());
    remembered_ = {
        {"prt_vertices", static_cast<double>(transfer.mesh.vertices.size())},
        {"prt_vertex_bytes", bytes / std::max<double>(static_cast<double>(transfer.mesh.vertices.size()), 1.0)},
        {"prt_coefficients", static_cast<double>(store.light().kept.coefficients.size())},
        {"prt_error", std::hypot(transfer.bake->error(), store.light().left_out)},
        {"light_update_ms", store.light().ms}};
  }
  PointValue read_view(int view, const LayerContext& layer) const {
    const GridSize& size = layer.surfaces.size();
    const Texture values = Texture::make_2d("view", GL_RGBA32F, size.grid_width(), size.grid_height());
    const float black[4] = {};
    glClearTexImage(values.get(), 0, GL_RGBA, GL_FLOAT, black);
    if (const TransferStore* store = find_store(layer.frame, layer.plan)) {
      layer.surfaces.bind();
      const Program& program = layer.frame.programs.get({kView, "", defines(store->buffers())});
      set_counts(program, store->buffers());
      program.set("u_view", view);
      program.set("u_environment_scale", layer.frame.request.env_scale);
      glBindImageTexture(kImageRadiance, values.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
      dispatch_tiles(program, layer.surfaces.tiles(), kPerPoint);
    }
    return value_of_texels<float>(values, GL_RGBA, GL_FLOAT, 1,
                                  [](const float* v) { return glm::vec3(v[0], v[1], v[2]); });
  }

  Texture marks_;
  Buffer counters_ = Buffer("transfer counters", 2 * sizeof(unsigned));
  ShadingCounts counts_;
  std::map<std::string, double> remembered_;
};

}  // namespace

std::unique_ptr<ShadingMode> make_transfer_mode() { return std::make_unique<TransferMode>(); }

std::vector<ShaderVariant> transfer_shader_variants() {
  std::vector<ShaderVariant> variants;
  const auto add = [&](int terms, bool joint) {
    variants.push_back({kVertices, "", defines(terms, joint)});
    variants.push_back({kView, "", defines(terms, joint)});
    for (const bool baked : {false, true}) {
      if (joint && !baked) continue;
      variants.push_back({kShade, "", defines(terms, joint, baked)});
      variants.push_back({kShade, "", {{"REFLECTED", "1"}}});
      const ShaderDefines more = defines(terms, joint, baked);
      variants.back().defines.insert(variants.back().defines.end(), more.begin(), more.end());
    }
  };
  add(transfer_terms(0), false);
  add(transfer_terms(kMostMaterialComponents), false);
  add(0, true);
  return variants;
}

}  // namespace maquette
