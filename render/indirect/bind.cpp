#include "render/indirect/bind.h"

#include "render/gl/bindings.h"

namespace maquette {

ShaderVariant reflected_indirect_variant(bool measured) {
  return {"shading/indirect.comp", "", {{"REFLECTED", "1"}, {"MEASURED", flag(measured)}}};
}

void bind_indirect(const Program& program, const SceneState& scene, const IndirectKey& key) {
  program.set("u_bias", key.bias);
  program.set("u_back", key.sides == 2 ? static_cast<int>(scene.geometry().positions.size()) : 0);
  glBindTextureUnit(kUnitIndirect, key.view.get());
}

const IndirectKey& nearest_bake(const IndirectBuffers& indirect) {
  return indirect.blend() > 0.5f ? indirect.keys().back() : indirect.keys().front();
}

}  // namespace maquette
