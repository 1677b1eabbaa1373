#include "render/reflections/reflector_technique.h"

#include "render/bezier/projection.h"
#include "render/octree/reflections.h"
#include "render/raytraced/tracer.h"
#include "render/triangle/reflections.h"
#include "scenes/error.h"

namespace maquette {

const ReflectorTechniqueInfo& find_reflector_implementation(const std::string& name) {
  static const ReflectorTechniqueInfo kTechniques[] = {
      {"bezier", make_bezier_reflections},
      {"triangle", make_triangle_reflections},
      {"octree", make_octree_reflections},
      {"raytraced", make_raytraced_reflections},
  };
  for (const ReflectorTechniqueInfo& technique : kTechniques)
    if (technique.name == name) return technique;
  throw Error("--reflections " + name, "has no implementation");
}

}  // namespace maquette
