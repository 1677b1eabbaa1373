// The patches of the reflectors (render/reflections/reflector_set.cpp fills the block).
#include "shared/bindings.glsl"
#include "shared/bezier.glsl"
const int kMaxReflectors = 16, kMaxPatches = 128;
struct PatchRecord {
  vec4 origin;            // m
  vec4 coefficients[16];  // of BezierSurface
};
layout(std140, binding = kBlockReflectors) uniform Reflectors {
  // x: number of the patch that it is, -1: a mesh; y: 1: patches are fitted to the mesh; z: what is added to a triangle's number for its
  // record there (reflections/rays.comp)
  ivec4 u_mirrors[kMaxReflectors];
  PatchRecord u_patches[kMaxPatches];
};

BezierSurface load_patch(int number) {
  BezierSurface s;
  for (int k = 0; k < 16; ++k) s.c[k] = u_patches[number].coefficients[k].xyz;
  return s;
}
