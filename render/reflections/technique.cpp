#include "render/reflections/technique.h"

namespace maquette {

TechniqueInfo reflections_technique() {
  TechniqueInfo info;
  info.name = "reflections";
  info.kind = TechniqueKind::shared;
  info.help = "what the reflector techniques share";
  info.settings = {
      {.name = "reflections.resolution",
       .default_value = std::string("half"),
       .help = "of the reflected picture: full, half or quarter of the picture's own",
       .choices = {"full", "half", "quarter"}},
      {.name = "reflections.samples",
       .default_value = 16,
       .min = 2,
       .max = 4096,
       .help = "shading samples a pixel of what is reflected, in the modes that sample"},
      {.name = "reflections.mark",
       .default_value = std::string("hatch"),
       .help = "what a technique does not vouch for in its reflections: hatched in orange, or shown like the rest",
       .choices = {"hatch", "none"}},
  };
  return info;
}

std::vector<QualityStep> resolution_steps() {
  std::vector<QualityStep> steps;
  for (const char* resolution : {"quarter", "half", "full"})
    steps.push_back({.settings = {{"reflections.resolution", std::string(resolution)}}});
  return steps;
}

}  // namespace maquette
