#include "render/shading/technique.h"

namespace maquette {

/// What the modes that integrate the environment share: `uniform` and `bandwidth`.
Technique shading_technique() {
  Technique info;
  info.name = "shading";
  info.kind = TechniqueKind::shared;
  info.help = "what uniform and bandwidth share";
  info.settings = {
      {.name = "shading.visibility",
       .default_value = std::string("auto"),
       .help =
           "shadows: none (the paper), baked (of the environment, per vertex, found once in the background), traced "
           "(the samples' rays through an octree), rays (at every point to what is bright, the rest of the sky as "
           "baked until rays correct it at rest); auto is rays; see Light and shadow",
       .choices = {"auto", "none", "baked", "traced", "rays"}},
      {.name = "shading.indirect",
       .default_value = std::string("baked"),
       .help = "indirect light, where surfaces hide the sky from each other or visibility is baked or traced: none, "
               "baked (per vertex, in the background, follows the rotation of the environment)",
       .choices = {"none", "baked"}},
      {.name = "shading.reuse",
       .default_value = true,
       .help = "keeps what camera and surfaces alone decide (raster, G-buffer, curvature) from frame to frame while "
               "neither changes, and in mode bandwidth what points have gathered while only the environment rotates or "
               "a material is "
               "swapped; false draws every frame from nothing"},
  };
  info.views = {{"shaded"}, {"level"}, {"samples"}};
  info.restricted_settings = {{"shading.visibility", std::string("none")}, {"shading.indirect", std::string("none")}};
  return info;
}

}  // namespace maquette
