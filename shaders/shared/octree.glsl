// Sparse octree of a scene's surfaces (render/octree): the words of its nodes, and the traversal by a ray.
// Common subset of GLSL and C++ with GLM (render/octree/octree_shared.h).
//
// Words. Above the last level: child mask << 24 | first child, children in the order x + 2 y + 4 z; mask 0 is a leaf. On the last level: the
// plane. A plane word: normal (octahedral, 2 x 11 bits, kept with |x| + |y| + |z| = 1, so that no root is needed), offset from the cell's
// centre in cells (9 bits), 1 bit: the surface is that plane; without it the cell is solid between two planes of that normal (4 and 5 bits). A colour word: material 12 bits, coverage 4
// bits, mean colour of its textures (square root, 5 + 6 + 5 bits).
//
// The including file declares, of a node's index:
//   uint octree_word(int node);        // as above
//   uint octree_plane_word(int node);  // of a node above the last level
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

// Half the thickness of a planar cell's surface, in cells along the normal of length |x| + |y| + |z| = 1. Planes of neighbouring cells are fitted and
// rounded separately; their differences must not leave gaps.
const float kOctreeSlab = 0.05f;
// A surface whose distance from a plane is at most this (in cells) is stored as a plane.
const float kOctreePlanar = 0.08f;
// A solid thinner than this (in cells without much detail) is treated like a plane when hit from the front.
const float kOctreeThin = 0.25f;

// Number of levels of the deepest tree.
const int kOctreeStack = 14;

struct OctreePlane {
  vec3 normal;   // sum of the absolute components is 1; a small array of directions needs no unit vectors
  float offset;  // dot(normal, p) = offset, p in cells from the cell's centre
  bool planar;
  float low;     // bounds of a solid: low <= dot(normal, p) <= high
  float high;
};

MAQUETTE_FN OctreePlane octree_unpack_plane(uint word) {
  float u = float(int(word & 2047u)) * (2.0f / 2047.0f) - 1.0f;
  float v = float(int((word >> 11u) & 2047u)) * (2.0f / 2047.0f) - 1.0f;
  float y = 1.0f - abs(u) - abs(v);
  // The lower half sphere is folded outwards; see shared/octahedral.glsl.
  float x = y < 0.0f ? (u >= 0.0f ? 1.0f - abs(v) : abs(v) - 1.0f) : u;
  float z = y < 0.0f ? (v >= 0.0f ? 1.0f - abs(u) : abs(u) - 1.0f) : v;
  OctreePlane plane;
  plane.normal = vec3(x, y, z);
  plane.planar = (word >> 31u) != 0u;
  plane.offset = plane.planar ? float(int((word >> 22u) & 511u)) * (1.0f / 511.0f) - 0.5f : 0.0f;
  plane.low = float(int((word >> 22u) & 15u)) * (1.0f / 16.0f) - 0.5f;
  plane.high = float(int((word >> 26u) & 31u) + 1) * (1.0f / 32.0f) - 0.5f;
  return plane;
}

// Bits of a plane word for the normal, which may have any length above 0.
MAQUETTE_FN uint octree_pack_normal(vec3 normal) {
  float scale = 1.0f / max(abs(normal.x) + abs(normal.y) + abs(normal.z), 1.0e-30f);
  float p = normal.x * scale;
  float q = normal.z * scale;
  bool below = normal.y < 0.0f;
  float u = below ? (p >= 0.0f ? 1.0f - abs(q) : abs(q) - 1.0f) : p;
  float v = below ? (q >= 0.0f ? 1.0f - abs(p) : abs(p) - 1.0f) : q;
  return uint(clamp(int((u * 0.5f + 0.5f) * 2047.0f + 0.5f), 0, 2047)) |
         (uint(clamp(int((v * 0.5f + 0.5f) * 2047.0f + 0.5f), 0, 2047)) << 11u);
}

// `point` on the plane, in cells from the cell's centre.
MAQUETTE_FN uint octree_pack_plane(vec3 normal, vec3 point) {
  uint word = octree_pack_normal(normal);
  // The offset is computed for the rounded normal.
  float offset = dot(octree_unpack_plane(word).normal, point);
  return word | (uint(clamp(int((offset + 0.5f) * 511.0f + 0.5f), 0, 511)) << 22u) | 0x80000000u;
}

// A solid between `low` and `high` along the unit normal, measured from `point`, all in cells.
MAQUETTE_FN uint octree_pack_solid(vec3 normal, vec3 point, float low, float high) {
  uint word = octree_pack_normal(normal);
  vec3 n = octree_unpack_plane(word).normal;
  float middle = dot(n, point);
  float scale = sqrt(dot(n, n));
  // Rounded outwards with a small margin, because the normal is rounded too.
  float from = (middle + low * scale - 0.002f + 0.5f) * 16.0f;
  float to = (middle + high * scale + 0.002f + 0.5f) * 32.0f;
  return word | (uint(clamp(int(floor(from)), 0, 15)) << 22u) | (uint(clamp(int(ceil(to)) - 1, 0, 31)) << 26u);
}

struct OctreeColor {
  int material;
  float coverage;  // visible area of that material along the normal, relative to a cell's face, at most 1
  vec3 tint;       // linear
};

MAQUETTE_FN OctreeColor octree_unpack_color(uint word) {
  OctreeColor c;
  c.material = int(word & 4095u);
  c.coverage = float(int((word >> 12u) & 15u)) * (1.0f / 15.0f);
  float r = float(int((word >> 16u) & 31u)) * (1.0f / 31.0f);
  float g = float(int((word >> 21u) & 63u)) * (1.0f / 63.0f);
  float b = float(int(word >> 27u)) * (1.0f / 31.0f);
  c.tint = vec3(r * r, g * g, b * b);
  return c;
}

MAQUETTE_FN uint octree_pack_color(int material, float coverage, vec3 tint) {
  uint r = uint(int(sqrt(clamp(tint.x, 0.0f, 1.0f)) * 31.0f + 0.5f));
  uint g = uint(int(sqrt(clamp(tint.y, 0.0f, 1.0f)) * 63.0f + 0.5f));
  uint b = uint(int(sqrt(clamp(tint.z, 0.0f, 1.0f)) * 31.0f + 0.5f));
  uint share = uint(int(clamp(coverage, 0.0f, 1.0f) * 15.0f + 0.5f));
  return (uint(material) & 4095u) | (share << 12u) | (r << 16u) | (g << 21u) | (b << 27u);
}

struct OctreeFrame {
  vec3 corner;        // of the root, m
  float cells_per_m;  // of the last level
  int depth;          // at least 1
  int detail;         // number of the deepest levels, which only cells with much detail have
};

struct OctreeRay {
  vec3 origin;     // m
  vec3 direction;  // any length; the distances below are multiples of it
  float t_min;
  float t_max;
  float t_box;   // solid cells that the ray enters before this distance are skipped: they may contain the surface on which it starts
  float width;   // of the cone at the origin, m
  float spread;  // of the cone, m per unit of t; the traversal stops at cells that are no wider than the cone
};

struct OctreeHit {
  float t;
  int node;   // -1: nothing is hit
  int level;
  int steps;  // cells visited
};

// Width of the deepest cell around a point, in cells of the last level: of the leaf or the empty cell that contains it.
MAQUETTE_FN float octree_cell_at(OctreeFrame tree, vec3 point) {
  vec3 g = clamp((point - tree.corner) * tree.cells_per_m, vec3(0.0f), vec3(float((1 << tree.depth) - 1)));
  ivec3 cell = ivec3(g);
  uint word = octree_word(0);
  int shift = tree.depth;
  bool going = (word >> 24u) != 0u;
  while (going) {
    --shift;
    ivec3 bits = (cell >> shift) & 1;
    int child = bits.x | (bits.y << 1) | (bits.z << 2);
    uint upto = (word >> 24u) & ((2u << uint(child)) - 1u);
    going = shift > 0 && (upto >> uint(child)) != 0u;
    if (going) {
      word = octree_word(int(word & 0xffffffu) + bitCount(upto) - 1);
      going = (word >> 24u) != 0u;
    }
  }
  return float(1 << shift);
}

// First surface along the ray. All decisions compare distances to planes of the grid, and each distance is always computed by the same expression, so
// that no cell is missed or visited twice. Axes are mirrored so that the ray ascends along all three.
// Source: after Laine and Karras 2010, "Efficient Sparse Voxel Octrees", Sec. 3.2. Differs: integer cells, exact at any slope; planes in
// leaves; cone width.
MAQUETTE_FN OctreeHit octree_trace(OctreeFrame tree, OctreeRay ray) {
  float side = float(1 << tree.depth);
  vec3 g = (ray.origin - tree.corner) * tree.cells_per_m;
  vec3 d = ray.direction * tree.cells_per_m;
  bvec3 down = lessThan(d, vec3(0.0f));
  vec3 o = mix(g, vec3(side) - g, vec3(down));
  // An axis along which the ray does not move never decides, unless the ray lies in a plane of the grid, where 0 * 1e20 is still 0.
  vec3 slope = max(abs(d), vec3(1.0e-20f));
  vec3 inverse = vec3(1.0f) / slope;
  vec3 mirror = vec3(1.0f) - vec3(2.0f) * vec3(down);
  int flip = (down.x ? 1 : 0) | (down.y ? 2 : 0) | (down.z ? 4 : 0);

  OctreeHit hit;
  hit.t = ray.t_max;
  hit.node = -1;
  hit.level = 0;
  hit.steps = 0;
  vec3 near_t = (vec3(0.0f) - o) * inverse;
  vec3 far_t = (vec3(side) - o) * inverse;
  float t = max(max(near_t.x, near_t.y), max(near_t.z, ray.t_min));
  float t_end = min(min(far_t.x, far_t.y), min(far_t.z, ray.t_max));

  // Node words by the size of their cells. A software device keeps an array with computed indices in memory, separately for each invocation, which
  // took a third of the traversal time: in GLSL a loop compares all indices instead.
  uint stack[kOctreeStack];
#ifndef __cplusplus
  for (int k = 0; k < kOctreeStack; ++k) stack[k] = 0u;
#endif
  uint word = octree_word(0);
  int shift = tree.depth - 1;
  vec3 middle_t = (vec3(float(1 << shift)) - o) * inverse;
  ivec3 cell = ivec3(greaterThanEqual(vec3(t), middle_t)) << shift;
  bool going = t < t_end;
  while (going) {
    ++hit.steps;
    int size = 1 << shift;
    vec3 exit_t = (vec3(cell + size) - o) * inverse;
    float t_out = min(min(exit_t.x, exit_t.y), exit_t.z);
    ivec3 bits = (cell >> shift) & 1;
    int child = (bits.x | (bits.y << 1) | (bits.z << 2)) ^ flip;
    uint upto = (word >> 24u) & ((2u << uint(child)) - 1u);
    bool step_on = true;
    if ((upto >> uint(child)) != 0u) {
      int node = int(word & 0xffffffu) + bitCount(upto) - 1;
      uint next = octree_word(node);
      bool leaf = shift == 0 || (next >> 24u) == 0u || float(size) <= (ray.width + t * ray.spread) * tree.cells_per_m;
      if (leaf) {
        OctreePlane plane = octree_unpack_plane(shift == 0 ? next : octree_plane_word(node));
        float scale = 1.0f / float(size);
        vec3 n = plane.normal * mirror;
        float at_origin = dot(n, o - vec3(cell)) * scale - 0.5f * (n.x + n.y + n.z) - plane.offset;
        float per_t = dot(n, slope) * scale;
        float a = at_origin + t * per_t;
        float b = at_origin + t_out * per_t;
        float low = plane.planar ? -kOctreeSlab : plane.low;
        float high = plane.planar ? kOctreeSlab : plane.high;
        // A plane is hit in the middle of its slab, a solid where the ray enters it.
        float goal = plane.planar ? 0.0f : clamp(a, low, high);
        float t_hit = clamp((goal - at_origin) / (abs(per_t) > 1.0e-20f ? per_t : 1.0e-20f), t, t_out);
        t_hit = !plane.planar && goal == a ? t : t_hit;
        // Near the start of the ray a thick solid may be the surface it starts on; a thin one that the ray enters is not.
        bool thin = (high - low) * float(size) < kOctreeThin * float(1 << tree.detail) && per_t < 0.0f;
        bool solid = min(a, b) <= high && max(a, b) >= low && (plane.planar || thin || t_hit >= ray.t_box);
        if (solid && t_hit < ray.t_max) {
          hit.t = t_hit;
          hit.node = node;
          hit.level = tree.depth - shift;
          going = false;
        }
      } else {
        step_on = false;
#ifdef __cplusplus
        stack[shift] = word;
#else
        for (int k = 1; k < kOctreeStack; ++k) stack[k] = k == shift ? word : stack[k];
#endif
        word = next;
        --shift;
        middle_t = (vec3(cell + (1 << shift)) - o) * inverse;
        cell += ivec3(greaterThanEqual(vec3(t), middle_t)) << shift;
      }
    }
    if (step_on && going) {
      t = t_out;
      ivec3 to = cell + (ivec3(lessThanEqual(exit_t, vec3(t_out))) << shift);
      ivec3 changed = cell ^ to;
      int top = findMSB(changed.x | changed.y | changed.z);
      going = t < t_end && top < tree.depth;
      if (top > shift && going) {
        shift = top;
#ifdef __cplusplus
        word = stack[top];
#else
        for (int k = 1; k < kOctreeStack; ++k) word = k == top ? stack[k] : word;
#endif
      }
      cell = (to >> shift) << shift;
    }
  }
  return hit;
}
