// Group counts of the second round, from the lists' lengths.
layout(local_size_x = 1) in;
#include "shading/linear_id.glsl"
struct List {
  uint items, points, groups_x, groups_y, groups_z, samples, more_items, more_points;
};
layout(std430, binding = 1) buffer Counters { List b_lists[2]; };
uniform int u_item_capacity;
uniform int u_item_samples;
void main() {
  for (int k = 0; k < 2; ++k) {
    uint items = min(b_lists[k].more_items, uint(u_item_capacity));
    b_lists[k].items = items;
    b_lists[k].samples += uint(u_item_samples) * items;
    uint groups = (items + 63u) / 64u;
    b_lists[k].groups_x = min(groups, kGroupsPerRow);
    b_lists[k].groups_y = (groups + kGroupsPerRow - 1u) / kGroupsPerRow;
    b_lists[k].groups_z = 1u;
  }
}
