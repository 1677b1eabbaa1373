// Adds each offered triangle that is large on screen to the lists of its tiles whose rays may hit it. One group for each triangle.
layout(local_size_x = 8) in;
#define LARGE 1
#include "shared/bindings.glsl"
#include "reflections/nearest.glsl"
uniform int u_count;
uniform int u_per_row;  // of groups

void main() {
  int i = int(gl_WorkGroupID.x) + u_per_row * int(gl_WorkGroupID.y);
  if (i >= u_count) return;
  uint offer = b_large_offers[i];
  SceneTriangle triangle = SceneTriangle(uintBitsToFloat(b_offer[5u * offer].xyz), uintBitsToFloat(b_offer[5u * offer + 1u].xyz), uintBitsToFloat(b_offer[5u * offer + 2u].xyz));
  vec4 a = uintBitsToFloat(b_offer[5u * offer + 3u]), b = uintBitsToFloat(b_offer[5u * offer + 4u]);
  list_offer(make_box(a.xy, a.zw, b.xy, b.z), offer, 0.0, triangle, ivec2(int(gl_LocalInvocationID.x), 0), ivec2(8, 1));
}
