// The pixels of what is large on screen: a group for each of the list and for every so manieth row. A group does not take more than one,
// because llvmpipe ends the loops of an invocation after 65,535 rounds in all.
layout(local_size_x = 8) in;
#include "reflections/nearest.glsl"
layout(binding = 45) uniform usamplerBuffer t_boxes;  // the same as Boxes, its header in the first texel
uniform int u_count;
uniform int u_per_row;  // of groups

void main() {
  int i = int(gl_WorkGroupID.x) + u_per_row * int(gl_WorkGroupID.y);
  if (i >= u_count) return;
  int at = 3 * i + 1;
  vec4 a = uintBitsToFloat(texelFetch(t_boxes, at));
  uvec4 b = texelFetch(t_boxes, at + 1);
  uvec2 of = texelFetch(t_boxes, at + 2).xy;
  vec3 rest = uintBitsToFloat(b.xyz);
  offer_box(make_box(a.xy, a.zw, rest.xy, rest.z), uintBitsToFloat(of.y), b.w, int(of.x),
            ivec2(int(gl_LocalInvocationID.x), int(gl_WorkGroupID.z)), ivec2(8, int(gl_NumWorkGroups.z)));
}
