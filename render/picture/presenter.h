#pragma once

#include <glm/glm.hpp>
#include <string>

#include "render/gl/program_cache.h"

namespace maquette {

/// How a picture is shown.
struct PresentRule {
  float exposure_ev = 0.0f;
  int curve = -1;  ///< tonemap_index; -1: it is display-encoded already
  int side = 1;    ///< points a pixel along each axis
};

/// Draws a picture into the rectangle of the currently bound framebuffer, tone mapped.
void present(const Texture& picture, const glm::ivec4& rectangle, const PresentRule& rule, ProgramCache* programs);
ShaderVariant present_variant(int side);

/// Mesa leaves in the slot of a buffer texture what the program before had there, and a software device compiles a
/// program anew for each sampler state that it meets: half a second for the large ones, in some later frame. This gives
/// all texture slots of compute programs the state that nearly all textures share.
class TextureSlots {
 public:
  void settle(ProgramCache* programs);
  static ShaderVariant variant() { return {"shading/slots.comp", "", {}}; }

 private:
  Texture texture_;
};

}  // namespace maquette
