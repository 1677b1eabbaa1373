#include "render/ground/technique.h"

namespace maquette {

Technique ground_technique() {
  Technique info;
  info.name = "ground";
  info.kind = TechniqueKind::shared;
  info.help = "a ground below a scene that has none";
  info.settings = {
      {.name = "ground.kind",
       .default_value = std::string("none"),
       .help =
           "none, or projected: a disc below the scene that shows the environment's lower half and catches shadows. "
           "The window chooses it for a file with nothing level below it",
       .choices = {"none", "projected"}},
      {.name = "ground.height",
       .default_value = 1.6,
       .min = 0.01,
       .max = 1000.0,
       .unit = "m",
       .help = "of the point from which the environment was photographed, above the ground"},
      {.name = "ground.roughness",
       .default_value = 1.0,
       .min = 0.0,
       .max = 1.0,
       .help = "1: matte, without gloss; below, it has the gloss of a wet or polished floor"},
  };
  return info;
}

}  // namespace maquette
