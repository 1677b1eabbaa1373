#include "render/triangle/technique.h"

namespace maquette {

TechniqueInfo triangle_technique() {
  TechniqueInfo info;
  info.name = "triangle";
  info.kind = TechniqueKind::reflector;
  info.help =
      "vertices projected into triangles with normals, where the cubic of each has its root; serves meshes and patches";
  info.settings = {
      {.name = "triangle.side",
       .default_value = 8,
       .min = 2,
       .max = 32,
       .help = "a patch becomes this many quads a side; the picture is the same, the time is not"},
  };
  info.quality_steps = {{.settings = {{"reflections.resolution", std::string("quarter")}}},
                        {.settings = {{"reflections.resolution", std::string("half")}}},
                        {.settings = {{"reflections.resolution", std::string("full")}}}};
  info.add_passes = [](const SceneFacts&, const Settings&, const ViewInfo&, FramePlan* plan) {
    plan->passes.push_back(
        {"projection", "the scene's triangles that may be seen in a triangle of a reflector, projected into it"});
  };
  return info;
}

}  // namespace maquette
