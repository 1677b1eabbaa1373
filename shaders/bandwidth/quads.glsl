// Quads of 2 x 2 grid points from a list of quads.comp.
#include "shared/bindings.glsl"
layout(std430, binding = kBufferQuads) readonly buffer Quads { uint b_quads[]; };  // x | y << 16 of their first points
uniform int u_quads;

/// First point of an entry; x < 0 beyond the list.
ivec2 listed_quad(int entry) {
  if (entry >= u_quads) return ivec2(-1);
  uint packed_point = b_quads[entry];
  return ivec2(packed_point & 65535u, packed_point >> 16u);
}
