// Averages the work items of each shaded point into the picture.
layout(local_size_x = 64) in;
struct ShadedPoint {
  uint pixel, first_item, item_count, level;
};
struct List {
  uint items, points, groups_x, groups_y, groups_z, samples, visible, overflow;
};
layout(std430, binding = 1) readonly buffer Counters { List b_lists[2]; };
layout(std430, binding = 2) readonly buffer Points { ShadedPoint b_points[]; };
layout(binding = 22) uniform samplerBuffer t_partial;
layout(binding = 0, rgba32f) uniform writeonly image2D o_radiance;
uniform int u_list;
void main() {
  uint count = b_lists[u_list].points;
  for (uint id = gl_GlobalInvocationID.x; id < count; id += gl_NumWorkGroups.x * 64u) {
    ShadedPoint point = b_points[id];
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < point.item_count; ++i) sum += texelFetch(t_partial, int(point.first_item + i)).rgb;
    sum /= float(max(point.item_count, 1u));
    // A picture never holds NaN or infinity, whatever a table holds.
    if (any(isnan(sum)) || any(isinf(sum))) sum = vec3(0.0);
    imageStore(o_radiance, ivec2(point.pixel & 65535u, point.pixel >> 16u), vec4(sum, 1.0));
  }
}
