// Directional visibility of one side of a vertex: 16 x 16 cells of the octahedral map, one bit each (render/visibility). Needs
// shared/octahedral.glsl before it. Common subset of GLSL and C++ with GLM (render/math/shared_formulas.h).
//
// The map is extended by a border of one cell, which repeats the cells across the map's folds, and is stored in words of 8 x 4 cells that overlap by
// one cell: the four cells around any direction are in one word. Use, per direction: the word and the position in it, that word of the three
// vertices of the triangle, and the interpolated value of the four bits:
//   VisibilityCorner corner = visibility_corner(direction);
//   VisibilityBitPosition place = visibility_bit_position(corner.lower);
//   float v = dot(visibility_shares(corner.fraction), b.x * visibility_bits(word_a, place.shift) + ...);

#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

const int kVisibilityCells = 16;  // along one side of the map

// Maps cell indices one step outside the square to the other half of the same edge (the map's fold).
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
// Bit of the cell that holds the direction (any length above 0).
MAQUETTE_FN int visibility_bit(vec3 direction) {
  vec2 uv = octahedral_from_direction(direction);
  int x = clamp(int(uv.x * float(kVisibilityCells)), 0, kVisibilityCells - 1);
  int y = clamp(int(uv.y * float(kVisibilityCells)), 0, kVisibilityCells - 1);
  return y * kVisibilityCells + x;
}

// The four cells whose centres surround a direction, and its position between them.
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

const int kVisibilityWords = 18;  // of a side: three across, six down

// Position of the four bits around a direction: the lower left one at bit `shift` of the word, its right neighbour 1 higher, the upper two 8 and 9 higher.
struct VisibilityBitPosition {
  int word, shift;
};

MAQUETTE_FN VisibilityBitPosition visibility_bit_position(ivec2 lower) {
  ivec2 at = lower + ivec2(1);                                // in the map with its border, 0 to 16
  ivec2 tile = ivec2((at.x * 37) >> 8, (at.y * 11) >> 5);     // divided by 7 and by 3
  VisibilityBitPosition place;
  place.word = 3 * tile.y + tile.x;
  place.shift = 8 * (at.y - 3 * tile.y) + at.x - 7 * tile.x;
  return place;
}

// The four bits of a word at `shift`, lower left, lower right, upper left, upper right: 1 where visible.
MAQUETTE_FN vec4 visibility_bits(uint word, int shift) {
  uint w = word >> uint(shift);
  return vec4(float(w & 1u), float((w >> 1u) & 1u), float((w >> 8u) & 1u), float((w >> 9u) & 1u));
}

// Their bilinear weights.
MAQUETTE_FN vec4 visibility_shares(vec2 fraction) {
  vec2 lower = vec2(1.0f) - fraction;
  return vec4(lower.x * lower.y, fraction.x * lower.y, lower.x * fraction.y, fraction.x * fraction.y);
}
