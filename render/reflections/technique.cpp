#include "render/reflections/technique.h"

#include "render/reflections/reflections.h"

namespace maquette {

Technique reflections_technique() {
  Technique info;
  info.name = "reflections";
  info.kind = TechniqueKind::shared;
  info.help = "what the reflector techniques share";
  info.settings = {
      {.name = "reflections.resolution",
       .default_value = std::string("auto"),
       .help = "of the reflected picture: full, half or quarter of the picture's own; auto: half while something "
               "moves, full at rest (half for glossy surfaces whose rays are not exact)",
       .choices = {"auto", "full", "half", "quarter"}},
      {.name = "reflections.samples",
       .default_value = 16,
       .min = 2,
       .max = 4096,
       .help = "shading samples a pixel of what a mirror shows, in the modes that sample; half as many of what a pane "
               "does, which adds less"},
      {.name = "reflections.glossy",
       .default_value = 0.2,
       .min = 0.0,
       .max = 0.5,
       .help = "opaque surfaces up to this roughness mirror the scene too, with techniques that follow single rays and "
               "where the sky has shadows; 0: none but those named with --reflector"},
      {.name = "reflections.mark",
       .default_value = std::string("hatch"),
       .help = "what a technique has low confidence in in its reflections: hatched in orange, or shown like the rest",
       .choices = {"hatch", "none"}},
      {.name = "reflections.ghost",
       .default_value = false,
       .help = "the second image too, which the back faces of panes mirror: as many rays again"},
      {.name = "reflections.thickness",
       .default_value = 5.0,
       .min = 0.0,
       .max = 50.0,
       .unit = "mm",
       .help = "of the panes, for their second image"},
      {.name = "reflections.wedge",
       .default_value = 0.0,
       .min = -20.0,
       .max = 20.0,
       .unit = "mrad",
       .help = "by which their faces part upwards"},
      {.name = "reflections.layer",
       .default_value = std::string("all"),
       .help =
           "of the light at panes: all; transmitted: what is seen through them; reflected: what they mirror, on black; "
           "ghost: their second image alone, with reflections.ghost. reflected and transmitted sum to all; mode "
           "reference always shows all",
       .choices = {"all", "transmitted", "reflected", "ghost"}},
      {.name = "reflections.skip",
       .default_value = 0.05,
       .min = 0.0,
       .max = 0.5,
       .help =
           "in pictures for the eye a mirrored ray is not followed where what it may bring at most is this share of "
           "what is seen through the pane; 0: all are followed. Never in EXR files and reports"},
  };
  info.views = Reflections::views();
  info.views.push_back({"glossy", "what glossy surfaces mirror", ViewColors::radiance});
  info.shader_variants = Reflections::shader_variants;
  info.words = {
      {Word::Kind::counter, "glossy_rays", "mirrored rays of glossy opaque surfaces"},
      {Word::Kind::counter, "rays_skipped", "mirrored rays that were not followed"},
      {Word::Kind::counter, "rays_skipped_share", "of all"},
  };
  info.has_effect = [](const Technique&, const Technique* reflector, const Settings&) { return reflector != nullptr; };
  return info;
}

void add_resolve_pass(FramePlan* plan) {
  plan->passes.push_back({"reflected gbuffer",
                          "normal and material, textures applied, of what the mirrored rays hit",
                          {"hits"},
                          {"hits"}});
}

std::vector<QualityStep> resolution_steps() {
  std::vector<QualityStep> steps;
  for (const char* resolution : {"quarter", "half", "full"})
    steps.push_back({.settings = {{"reflections.resolution", std::string(resolution)}}});
  return steps;
}

}  // namespace maquette
