#pragma once

// shaders/shared/cubic.glsl and triangle_mirror.glsl as C++: the very lines that the GPU compiles.
#include <glm/glm.hpp>

#ifndef MAQUETTE_FN
#define MAQUETTE_FN inline
#endif
#ifndef PRECISE
#define PRECISE  // C++ keeps the order of float operations by itself
#endif

namespace maquette::mirror {
using namespace glm;
#include "shared/cubic.glsl"
#include "shared/triangle_mirror.glsl"
}  // namespace maquette::mirror

namespace maquette {

/// The vertex-independent terms, found in double. Directions are those that the eye's rays are reflected to at the
/// vertices.
mirror::TriangleMirror make_triangle_mirror(const glm::vec3 (&vertices)[3], const glm::vec3 (&directions)[3]);

}  // namespace maquette
