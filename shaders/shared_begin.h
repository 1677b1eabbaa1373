// Opens the C++ side of shaders/shared/*.glsl (no include guard: it surrounds each include).
//
//   #include "shared_begin.h"
//   #include "shared/latlong.glsl"
//   #include "shared_end.h"
//
// puts the very lines that the GPU compiles into maquette::shader, with internal linkage.
#include <cmath>
#include <glm/glm.hpp>
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
// NOLINTBEGIN
namespace maquette::shader {
namespace {
using namespace glm;  // NOLINT(google-build-using-namespace): GLSL's names
