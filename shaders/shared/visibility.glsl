// Directional visibility bits of a vertex: 16 x 16 cells of the octahedral map, bit = y * 16 + x, 8 words of 32 bits, here as
// two vectors of four (render/visibility). Needs shared/octahedral.glsl before it.
// Common subset of GLSL and C++ with GLM (render/visibility/visibility_shared.h).
//
// Use, per light sample: one dithered bit index for the direction, then that same bit of the three vertices of the triangle,
// blended by the barycentrics:
//   int bit = visibility_dithered_bit(wi, n, u);
//   float v = b.x * visibility_test(low_a, high_a, bit) + b.y * visibility_test(...) + b.z * visibility_test(...);
// Its expectation over u is the bilinear interpolation of the bits in the map.

#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

const int kVisibilityCells = 16;  // along one side of the map

// Cell indices one step outside the square continue on the other half of the same edge (the map's fold); corners meet.
MAQUETTE_FN ivec2 visibility_wrap(ivec2 cell) {
  int last = kVisibilityCells - 1;
  ivec2 c = cell;
  bool left = c.x < 0;
  bool right = c.x > last;
  c.y = left || right ? last - c.y : c.y;
  c.x = left ? 0 : (right ? last : c.x);
  bool below = c.y < 0;
  bool above = c.y > last;
  c.x = below || above ? last - c.x : c.x;
  c.y = below ? 0 : (above ? last : c.y);
  return c;
}

MAQUETTE_FN vec2 visibility_cell_center(ivec2 cell) {
  float step_size = 1.0f / float(kVisibilityCells);
  return vec2((float(cell.x) + 0.5f) * step_size, (float(cell.y) + 0.5f) * step_size);
}
// Unit direction of a cell's centre; cell inside the map.
MAQUETTE_FN vec3 visibility_cell_direction(ivec2 cell) { return direction_from_octahedral(visibility_cell_center(cell)); }
// Of the sign of the cosine between the centre's direction and `normal`.
MAQUETTE_FN float visibility_cell_height(ivec2 cell, vec3 normal) {
  return dot(unscaled_from_octahedral(visibility_cell_center(cell)), normal);
}

// Bit of the cell that holds the direction (any length above 0).
MAQUETTE_FN int visibility_bit(vec3 direction) {
  vec2 uv = octahedral_from_direction(direction);
  int x = clamp(int(uv.x * float(kVisibilityCells)), 0, kVisibilityCells - 1);
  int y = clamp(int(uv.y * float(kVisibilityCells)), 0, kVisibilityCells - 1);
  return y * kVisibilityCells + x;
}

// The four cells whose centres surround a direction, and where it lies between them.
struct VisibilityCorner {
  ivec2 lower;    // lower cell, may be one step outside: wrap before use
  vec2 fraction;  // in [0, 1], weight of the upper cell per axis
};

MAQUETTE_FN VisibilityCorner visibility_corner(vec3 direction) {
  vec2 uv = octahedral_from_direction(direction);
  float x = uv.x * float(kVisibilityCells) - 0.5f;
  float y = uv.y * float(kVisibilityCells) - 0.5f;
  VisibilityCorner corner;
  corner.lower = ivec2(int(floor(x)), int(floor(y)));
  corner.fraction = vec2(x - floor(x), y - floor(y));
  return corner;
}

// Bit of one of the four surrounding cells, chosen with its bilinear weight by u in [0, 1)^2.
//
// The cells on the far side of the surface belong to the far side (a sheet is lit from both), so near the horizon only cells
// whose centre is above the plane of `normal` are taken. `normal`: the interpolated vertex normal, unit, turned to the viewer's side; the caller
// rejects directions below it. `direction`: unit.
MAQUETTE_FN int visibility_dithered_bit(vec3 direction, vec3 normal, vec2 u) {
  VisibilityCorner corner = visibility_corner(direction);
  int dx = u.x < corner.fraction.x ? 1 : 0;
  int dy = u.y < corner.fraction.y ? 1 : 0;
  ivec2 cell = visibility_wrap(ivec2(corner.lower.x + dx, corner.lower.y + dy));
  // A neighbouring centre is at most 0.48 rad away (checked over the sphere), so higher up nothing needs a look.
  if (dot(direction, normal) < 0.462f && visibility_cell_height(cell, normal) <= 0.0f) {
    // The direction lies between the four centres, so one of them at least is above; folds and ties keep the first choice.
    ivec2 other_x = visibility_wrap(ivec2(corner.lower.x + 1 - dx, corner.lower.y + dy));
    ivec2 other_y = visibility_wrap(ivec2(corner.lower.x + dx, corner.lower.y + 1 - dy));
    ivec2 other = visibility_wrap(ivec2(corner.lower.x + 1 - dx, corner.lower.y + 1 - dy));
    bool x_nearer = abs(corner.fraction.x - 0.5f) < abs(corner.fraction.y - 0.5f);
    ivec2 second = x_nearer ? other_x : other_y;
    ivec2 third = x_nearer ? other_y : other_x;
    bool take_second = visibility_cell_height(second, normal) > 0.0f;
    bool take_third = !take_second && visibility_cell_height(third, normal) > 0.0f;
    bool take_other = !take_second && !take_third && visibility_cell_height(other, normal) > 0.0f;
    cell = take_second ? second : (take_third ? third : (take_other ? other : cell));
  }
  return cell.y * kVisibilityCells + cell.x;
}

// Chances with which visibility_dithered_bit takes each of the four cells, lower left, lower right, upper left, upper right. `share`: their bilinear
// weights; `x_nearer`: as there; `height`: cosine of the direction to the normal; `heights`: visibility_cell_height of the cells.
MAQUETTE_FN vec4 visibility_shares_above(vec4 share, bool x_nearer, float height, vec4 heights) {
  if (height >= 0.462f) return share;
  bool a0 = heights.x > 0.0f, a1 = heights.y > 0.0f, a2 = heights.z > 0.0f, a3 = heights.w > 0.0f;
  // Where the share of a cell below goes: to its neighbour along the nearer axis, else along the other, else across.
  vec4 along = x_nearer ? vec4(a1 ? 1.0f : 0.0f, a0 ? 1.0f : 0.0f, a3 ? 1.0f : 0.0f, a2 ? 1.0f : 0.0f)
                        : vec4(a2 ? 1.0f : 0.0f, a3 ? 1.0f : 0.0f, a0 ? 1.0f : 0.0f, a1 ? 1.0f : 0.0f);
  vec4 other = x_nearer ? vec4(a2 ? 1.0f : 0.0f, a3 ? 1.0f : 0.0f, a0 ? 1.0f : 0.0f, a1 ? 1.0f : 0.0f)
                        : vec4(a1 ? 1.0f : 0.0f, a0 ? 1.0f : 0.0f, a3 ? 1.0f : 0.0f, a2 ? 1.0f : 0.0f);
  vec4 across = vec4(a3 ? 1.0f : 0.0f, a2 ? 1.0f : 0.0f, a1 ? 1.0f : 0.0f, a0 ? 1.0f : 0.0f);
  vec4 above = vec4(a0 ? 1.0f : 0.0f, a1 ? 1.0f : 0.0f, a2 ? 1.0f : 0.0f, a3 ? 1.0f : 0.0f);
  vec4 one = vec4(1.0f);
  vec4 lost = share * (one - above);
  vec4 to_along = lost * along;
  vec4 to_other = lost * (one - along) * other;
  vec4 to_across = lost * (one - along) * (one - other) * across;
  vec4 kept = share - to_along - to_other - to_across;
  vec4 x = x_nearer ? to_along : to_other, y = x_nearer ? to_other : to_along;
  return kept + vec4(x.y + y.z + to_across.w, x.x + y.w + to_across.z, x.w + y.x + to_across.y, x.z + y.y + to_across.x);
}

// 1 where the bit is set (unoccluded), else 0. low: words 0 to 3, high: words 4 to 7.
MAQUETTE_FN float visibility_test(uvec4 low, uvec4 high, int bit) {
  int word = bit >> 5;
  uint bits = word < 4 ? low[word] : high[word & 3];
  return float((bits >> uint(bit & 31)) & 1u);
}
