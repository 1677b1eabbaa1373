#include "render/octree/reflections.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "render/gl/bindings.h"
#include "render/gl/dispatch.h"
#include "render/octree/cell_brdf_buffers.h"
#include "render/octree/octree_buffers.h"

namespace maquette {

namespace {

ShaderVariant octree_reflect_variant(bool cells, bool glossy) {
  return {"octree/reflect.comp", "", {{"CELLS", flag(cells)}, {"GLOSSY", flag(glossy)}}};
}

ShaderVariant shade_cells_variant(bool traced) {
  return {"octree/shade_cells.comp", "", {{"VISIBILITY", traced ? "2" : "0"}}};
}

class OctreeReflections : public ReflectorTechnique {
 public:
  explicit OctreeReflections(bool glossy) : glossy_(glossy) {}
  void trace(const ReflectionFrame& frame) override {
    assert(frame.octree);
    ReflectionTargets& t = *frame.targets;
    const Program& program = frame.programs->get(octree_reflect_variant(frame.cells != nullptr, glossy_));
    frame.octree->set_uniforms(program);
    if (glossy_)
      glBindTextureUnit(kUnitLobeWidth, t.focus.get());
    else
      set_mirrors(frame, program);
    frame.octree->bind_triangles();
    glBindImageTexture(kImageSurface, t.surface.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32UI);
    glBindImageTexture(kImageDepth, t.depth.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    glBindImageTexture(kImageOctreeTriangle, t.triangle.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32UI);
    glBindImageTexture(kImageGuide, t.guide.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RG32UI);
    glBindImageTexture(kImageOctreeEffort, t.effort.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RG8UI);
    if (frame.cells) prepare_layers(frame, program);
    for (bool again = true; again;) {
      counters_.clear_to_zero();
      glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferOctreeCounters, counters_.get());
      frame.for_each_ray(program);
      if (!frame.cells) break;
      counters_.read(2 * sizeof(unsigned), sizeof layer_count_, &layer_count_);
      again = layer_count_ > layer_capacity_;
      if (again) make_layers(layer_count_, program);
    }
    frame.timer->end("rays");
  }
  bool shade_layers(const ReflectionFrame& frame, bool traced, int samples) override {
    if (!frame.cells) return false;
    glBindTextureUnit(kUnitOctreeLayers, frame.targets->layers.get());
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferOctreeLayers, layers_.get());
    if (layer_count_ == 0) return true;
    const Program& program = frame.programs->get(shade_cells_variant(traced));
    frame.octree->set_uniforms(program);
    program.set("u_layer_count", static_cast<int>(layer_count_));
    program.set("u_samples", samples);
    const int count = group_count(static_cast<int>(layer_count_), 64), row = std::min(count, 65535);
    glUseProgram(program.get());
    glDispatchCompute(static_cast<GLuint>(row), static_cast<GLuint>(group_count(count, row)), 1);
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
    return true;
  }
  bool resolves() const override { return true; }
  void add_counters(std::map<std::string, double>* counters) const override {
    unsigned values[3];
    counters_.read(0, sizeof values, values);
    (*counters)[glossy_ ? "glossy_rays" : "rays"] = values[0];
    if (glossy_) return;
    (*counters)["octree_steps"] = values[1];
    if (layers_) (*counters)["cell_layers"] = values[2];
  }

 private:
  void make_layers(unsigned capacity, const Program& program) {
    layer_capacity_ = std::max(capacity, 64u);
    layers_ = Buffer("cell layers", std::size_t{layer_capacity_} * 16);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferOctreeLayers, layers_.get());
    program.set("u_layer_capacity", static_cast<int>(layer_capacity_));
  }
  void prepare_layers(const ReflectionFrame& frame, const Program& program) {
    ReflectionTargets& t = *frame.targets;
    frame.cells->bind();
    if (!t.layers) t.layers = Texture::make_2d("cell layers", GL_RG32UI, t.width, t.height);
    glBindImageTexture(kImageOctreeLayers, t.layers.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RG32UI);
    make_layers(layers_ ? layer_capacity_ : static_cast<unsigned>(t.width * t.height / 2), program);
    program.set("u_all_cells", frame.settings->get_string("octree.brdf") == "all" ? 1 : 0);
  }
  static void set_mirrors(const ReflectionFrame& frame, const Program& program) {
    std::array<GLint, kMaxReflectors> materials;
    std::array<glm::vec3, kMaxReflectors> low{}, high{};
    materials.fill(-1);
    for (std::size_t k = 0; k < frame.reflectors->size(); ++k) {
      const Reflector& reflector = (*frame.reflectors)[k];
      if (!reflector.mirror) continue;
      materials[k] = frame.buffers->material(reflector.item);
      low[k] = frame.buffers->bounds(reflector.item).min;
      high[k] = frame.buffers->bounds(reflector.item).max;
    }
    constexpr auto kCount = static_cast<GLsizei>(kMaxReflectors);
    glProgramUniform1iv(program.get(), program.location("u_own_material"), kCount, materials.data());
    glProgramUniform3fv(program.get(), program.location("u_own_low"), kCount, &low[0].x);
    glProgramUniform3fv(program.get(), program.location("u_own_high"), kCount, &high[0].x);
  }
  bool glossy_;
  Buffer counters_ = Buffer("octree counters", 3 * sizeof(unsigned));
  Buffer layers_;
  unsigned layer_capacity_ = 0, layer_count_ = 0;
};

}  // namespace

std::vector<ShaderVariant> octree_reflection_shader_variants() {
  std::vector<ShaderVariant> variants{shade_cells_variant(false), shade_cells_variant(true)};
  for (int k = 0; k < 4; ++k) variants.push_back(octree_reflect_variant(k & 1, k & 2));
  return variants;
}

std::unique_ptr<ReflectorTechnique> make_octree_reflections() { return std::make_unique<OctreeReflections>(false); }
std::unique_ptr<ReflectorTechnique> make_glossy_octree_reflections() {
  return std::make_unique<OctreeReflections>(true);
}

}  // namespace maquette
