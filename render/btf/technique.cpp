#include "render/btf/technique.h"

#include "scenes/btf/btf.h"

namespace maquette {

Technique btf_technique() {
  Technique info;
  info.name = "btf";
  info.kind = TechniqueKind::shared;
  info.help = "how BTFs are read";
  info.settings = {
      {.name = "btf.cosine",
       .default_value = true,
       .help = "the light's cosine is in the values of BTF images: a value is pi times rho times the cosine; false: pi "
               "times rho. A .btf file that says it wins"},
      {.name = "btf.gamma",
       .default_value = 0.0,
       .min = 0.0,
       .max = 8.0,
       .help = "exponent that decodes the values of BTF images; 0: the sRGB curve for PNG and JPEG, 1 for all others"},
      {.name = "btf.texel_mm",
       .default_value = 0.0,
       .min = 0.0,
       .max = 1000.0,
       .unit = "mm",
       .help = "side of a BTF's texel on the surface; 0: what its file says, 0.25 where it says nothing"},
      {.name = "btf.components",
       .default_value = 8,
       .min = 0,
       .max = kMostBtfComponents,
       .help = "eigen-textures that are kept of each view of a BTF, besides the mean"},
  };
  return info;
}

}  // namespace maquette
