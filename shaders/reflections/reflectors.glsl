// The patches among the reflectors (render/renderer_reflections.cpp fills the block).
#include "shared/bezier.glsl"
const int kMaxReflectors = 16;
struct ReflectorRecord {
  vec4 origin;            // m; w: 1 for a patch
  vec4 coefficients[16];  // of BezierSurface
};
layout(std140, binding = 1) uniform Reflectors { ReflectorRecord u_reflectors[kMaxReflectors]; };

BezierSurface load_surface(int reflector) {
  BezierSurface s;
  for (int k = 0; k < 16; ++k) s.c[k] = u_reflectors[reflector].coefficients[k].xyz;
  return s;
}
