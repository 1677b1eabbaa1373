// Directions, frame and pairs of the BRDFs of octree cells (render/octree/cell_brdf.h).
// Common subset of GLSL and C++ with GLM (render/octree/octree_shared.h).
//
// 98 directions: the pixels of two parabolic maps, 7 x 7 each, of the half spheres around +z and -z of the cell's frame. Pixels whose centres are
// outside the disc represent directions slightly beyond the horizon; they complete bilinear lookups near it.
// Source: the parametrisation of Mueller et al. as quoted with the method ("98 directions correspond to the pixels of a front- and a
// back-facing parabolic map"); Heidrich and Seidel 1998, "View-independent Environment Maps", Sec. 3.
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

const int kCellSide = 7;
const int kCellDirections = 98;
const int kCellPairs = 4851;  // of 98 directions, in either order

MAQUETTE_FN vec3 cell_direction_at(int map, float u, float v) {
  float r2 = u * u + v * v;
  float scale = 1.0f / (1.0f + r2);
  return vec3(2.0f * u * scale, 2.0f * v * scale, (map == 0 ? 1.0f - r2 : r2 - 1.0f) * scale);
}

MAQUETTE_FN vec3 cell_direction(int index) {
  int pixel = index % (kCellSide * kCellSide);
  float u = (float(pixel % kCellSide) + 0.5f) * (2.0f / float(kCellSide)) - 1.0f;
  float v = (float(pixel / kCellSide) + 0.5f) * (2.0f / float(kCellSide)) - 1.0f;
  return cell_direction_at(index / (kCellSide * kCellSide), u, v);
}

struct CellLookup {
  int first;   // index of the lower left of four neighbours: + 1, + kCellSide, + kCellSide + 1
  float x, y;  // their weights
};

// `d`: unit, in the cell's frame.
MAQUETTE_FN CellLookup cell_lookup(vec3 d) {
  float scale = 0.5f * float(kCellSide) / (1.0f + abs(d.z));
  float x = clamp(d.x * scale + 0.5f * float(kCellSide) - 0.5f, 0.0f, float(kCellSide - 1));
  float y = clamp(d.y * scale + 0.5f * float(kCellSide) - 0.5f, 0.0f, float(kCellSide - 1));
  int ix = int(min(x, float(kCellSide - 2)));
  int iy = int(min(y, float(kCellSide - 2)));
  CellLookup at;
  at.first = (d.z < 0.0f ? kCellSide * kCellSide : 0) + iy * kCellSide + ix;
  at.x = x - float(ix);
  at.y = y - float(iy);
  return at;
}

// Index of one of the four neighbours, chosen with its bilinear weight by two numbers in [0, 1).
MAQUETTE_FN int cell_sample_index(CellLookup at, float u, float v) {
  return at.first + (u < at.x ? 1 : 0) + (v < at.y ? kCellSide : 0);
}

MAQUETTE_FN int cell_pair(int a, int b) {
  int high = max(a, b);
  return high * (high + 1) / 2 + min(a, b);
}

// Tangent of a cell's frame: the second rule of the method, from the y axis unless the normal is close to it.
MAQUETTE_FN vec3 cell_tangent(vec3 normal) {
  vec3 axis = abs(normal.y) < 0.9f ? vec3(0.0f, 1.0f, 0.0f) : vec3(1.0f, 0.0f, 0.0f);
  return normalize(cross(axis, normal));
}

// Projected area of a cube relative to its face, seen along `d` (unit, in the frame of the cube's axes).
MAQUETTE_FN float cell_outline(vec3 d) { return abs(d.x) + abs(d.y) + abs(d.z); }
