#include "render/sg/technique.h"

#include "render/prefilter/lookup_mode.h"
#include "render/sg/tables.h"

namespace maquette {

Technique sg_technique() {
  constexpr const char* kShader = "sg/shade.comp";
  Technique technique =
      lookup_technique("sg", "spherical Gaussian fits per channel of every material", "lobe sharpness");
  technique.make_mode = [] { return make_lookup_mode(kShader, make_sg_tables); };
  technique.shader_variants = [] { return lookup_shader_variants(kShader); };
  return technique;
}

}  // namespace maquette
