// Group counts of the indirect dispatches, from the lengths of the lists.
layout(local_size_x = 1) in;
#include "shared/bindings.glsl"
#include "shading/linear_id.glsl"
struct List {
  uint items, points, groups_x, groups_y, groups_z, samples, visible, overflow;
};
layout(std430, binding = kBufferCounters) buffer Counters { List b_lists[2]; };
void main() {
  for (int k = 0; k < 2; ++k) {
    uint groups = (b_lists[k].items + 63u) / 64u;
    b_lists[k].groups_x = min(groups, kGroupsPerRow);
    b_lists[k].groups_y = (groups + kGroupsPerRow - 1u) / kGroupsPerRow;
    b_lists[k].groups_z = 1u;
  }
}
