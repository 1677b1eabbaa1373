#include "render/octree/reflections.h"

#include <array>
#include <cassert>

#include "render/octree/octree_buffers.h"

namespace maquette {

namespace {

int groups(int count, int size) { return (count + size - 1) / size; }

class OctreeReflections : public ReflectorTechnique {
 public:
  void trace(const ReflectionFrame& frame) override {
    assert(frame.octree);
    ReflectionTargets& t = *frame.targets;
    const Program& program = frame.programs->get({"octree/reflect.comp", "", {}});
    frame.octree->set_uniforms(program);
    set_mirrors(frame, program);
    glBindImageTexture(0, t.surface.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32UI);
    glBindImageTexture(1, t.depth.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
    glBindImageTexture(2, t.triangle.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32UI);
    glBindImageTexture(3, t.guide.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RG32UI);
    glBindImageTexture(4, t.effort.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RG8UI);
    counters_.clear_to_zero();
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 6, counters_.get());
    glUseProgram(program.get());
    glDispatchCompute(static_cast<GLuint>(groups(t.width, 8)), static_cast<GLuint>(groups(t.height, 8)), 1);
    glMemoryBarrier(GL_ALL_BARRIER_BITS);
    frame.timer->end("rays");
  }
  bool resolves() const override { return true; }
  void add_counters(std::map<std::string, double>* counters) const override {
    unsigned values[2];
    counters_.read(0, sizeof values, values);
    (*counters)["rays"] = values[0];
    (*counters)["octree_steps"] = values[1];
  }

 private:
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
  Buffer counters_ = Buffer("octree counters", 2 * sizeof(unsigned));
};

}  // namespace

std::unique_ptr<ReflectorTechnique> make_octree_reflections() { return std::make_unique<OctreeReflections>(); }

}  // namespace maquette
