// What is large on screen, onto its tiles' lists: a group for each.
layout(local_size_x = 8) in;
#include "reflections/nearest.glsl"
uniform int u_count;
uniform int u_per_row;  // of groups

void main() {
  int i = int(gl_WorkGroupID.x) + u_per_row * int(gl_WorkGroupID.y);
  if (i >= u_count) return;
  uint offer = b_large_offers[i];
  float nearest_m = uintBitsToFloat(b_offer[5u * offer + 1u].w);
  vec4 a = uintBitsToFloat(b_offer[5u * offer + 3u]), b = uintBitsToFloat(b_offer[5u * offer + 4u]);
  list_offer(make_box(a.xy, a.zw, b.xy, b.z), offer, nearest_m, ivec2(int(gl_LocalInvocationID.x), 0), ivec2(8, 1));
}
