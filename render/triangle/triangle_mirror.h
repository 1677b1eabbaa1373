#pragma once

// shaders/shared/cubic.glsl and triangle_mirror.glsl compiled as C++: the same source as on the GPU.
#include "scenes/shared_glsl.h"

#ifndef PRECISE
#define PRECISE  // C++ does not reorder float operations
#endif

namespace maquette::mirror {
using namespace glm;
#include "shared/cubic.glsl"
#include "shared/triangle_mirror.glsl"
}  // namespace maquette::mirror

namespace maquette {

/// The terms that do not depend on the reflected vertex, computed in double. `directions`: reflected eye rays at the
/// vertices.
mirror::TriangleMirror make_triangle_mirror(const glm::vec3 (&vertices)[3], const glm::vec3 (&directions)[3]);

}  // namespace maquette
