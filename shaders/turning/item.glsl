// What a work item or a shaded point carries of its history, in one word each. Needs frame.glsl.
/// Items have 2^least to 2^(least + 3) samples: the frame's own size of items is the largest.
int least_item_log2() { return max(findMSB(u_frame.sampling.y) - 3, 1); }

/// Large items lie at a list's end, so that the lanes of a vector do as many samples each. Points that go on have none.
bool is_large_item(int size_log2) { return size_log2 > least_item_log2(); }

struct TurnCounters {
  uint continued;  // points that go on from their past
  uint small_items[2], large_items[2];
};

struct TurnedItem {
  uint first_sample;  // of the point's own sequence
  int samples;
  float kept;  // share of the history that is kept
};
/// Shares of the history come in these steps, so that shading and gathering mean the same one.
const float kKeptSteps = 255.0;
/// Positions count items of the point's own size; they go round after 2^22, which repeats directions and biases nothing.
uint pack_turned_item(uint position, int size_log2, uint kept) {
  return (position & 0x3fffffu) | (uint(size_log2 - least_item_log2()) << 22u) | (kept << 24u);
}
TurnedItem unpack_turned_item(uint word) {
  int size_log2 = least_item_log2() + int((word >> 22u) & 3u);
  return TurnedItem((word & 0x3fffffu) << uint(size_log2), 1 << size_log2, float(word >> 24u) / kKeptSteps);
}

struct TurnedPoint {
  int level;
  int size_log2;  // of its items
  float kept;
  float worth;  // samples that its mean will be worth
};
/// `packed_point` holds the share of its items.
uint turned_item_of(uint packed_point, uint position, int size_log2) {
  return pack_turned_item(position, size_log2, (packed_point >> 8u) & 255u);
}
uint pack_turned_point(int level, int size_log2, uint kept, float worth) {
  return uint(level) | (uint(size_log2) << 4u) | (kept << 8u) | (packHalf2x16(vec2(min(worth, 60000.0), 0.0)) << 16u);
}
TurnedPoint unpack_turned_point(uint word) {
  return TurnedPoint(int(word & 15u), int((word >> 4u) & 15u), float((word >> 8u) & 255u) / kKeptSteps, unpackHalf2x16(word >> 16u).x);
}
