#include "render/splitsum/technique.h"

#include "render/prefilter/lookup_mode.h"
#include "render/splitsum/tables.h"

namespace maquette {

Technique splitsum_technique() {
  constexpr const char* kShader = "splitsum/shade.comp";
  Technique technique =
      lookup_technique("splitsum", "a prefiltered GGX fit of every material, as other viewers do", "roughness");
  technique.can.judges_reflections = true;
  technique.make_mode = [] { return make_lookup_mode(kShader, make_splitsum_tables); };
  technique.shader_variants = [] { return lookup_shader_variants(kShader); };
  return technique;
}

}  // namespace maquette
