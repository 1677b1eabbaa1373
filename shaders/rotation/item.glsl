// Temporal reuse: what a work item and a shaded point store of their history, in one word each. Needs frame.glsl.
/// Items have 2^least to 2^(least + 3) samples; the largest size is that of the frame's other items.
int least_item_log2() { return max(findMSB(u_frame.sampling.y) - 3, 1); }

/// Large items are stored at the end of a list, so that neighbouring invocations have the same number of samples. Points that reuse their history
/// have only small items.
bool is_large_item(int size_log2) { return size_log2 > least_item_log2(); }

struct TemporalCounters {
  uint continued;  // points that reuse their history
  uint small_items[2], large_items[2];
};

struct TemporalItem {
  uint first_sample;  // of the point's own sequence
  int samples;
  float kept;  // share of the history that is kept
};
/// Shares of the history are quantised in these steps, so that shading and gathering use the same value.
const float kKeptSteps = 255.0;
/// Positions count items of the point's own size. They wrap after 2^22 items, which repeats directions without bias.
uint pack_temporal_item(uint position, int size_log2, uint kept) {
  return (position & 0x3fffffu) | (uint(size_log2 - least_item_log2()) << 22u) | (kept << 24u);
}
TemporalItem unpack_temporal_item(uint word) {
  int size_log2 = least_item_log2() + int((word >> 22u) & 3u);
  return TemporalItem((word & 0x3fffffu) << uint(size_log2), 1 << size_log2, float(word >> 24u) / kKeptSteps);
}

struct TemporalPoint {
  int level;
  int size_log2;  // of its items
  float kept;
  float worth;  // number of independent samples that its mean will be equivalent to
};
/// `packed_point` holds the share of its items.
uint temporal_item_of(uint packed_point, uint position, int size_log2) {
  return pack_temporal_item(position, size_log2, (packed_point >> 8u) & 255u);
}
uint pack_temporal_point(int level, int size_log2, uint kept, float worth) {
  return uint(level) | (uint(size_log2) << 4u) | (kept << 8u) | (packHalf2x16(vec2(min(worth, 60000.0), 0.0)) << 16u);
}
TemporalPoint unpack_temporal_point(uint word) {
  return TemporalPoint(int(word & 15u), int((word >> 4u) & 15u), float((word >> 8u) & 255u) / kKeptSteps, unpackHalf2x16(word >> 16u).x);
}
