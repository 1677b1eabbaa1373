// The surface where a ray hits a cell of the octree, interpolated between the means of the cells around. Needs shared/octree.glsl; common subset
// of GLSL and C++ with GLM (render/octree/octree_shared.h).
//
// The including file declares uint octree_color_word(int node).

/// Normals of neighbours that differ by more than this (cosine; 60 degrees) belong to the other side of an edge.
const float kOctreeSameSide = 0.5f;

/// With a normal that faces away by more than this (cosine) the back is visible.
const float kOctreeBack = 0.3f;

/// Additional weight of the hit cell's own mean if it was not subdivided: neighbours may contain surfaces hidden behind it.
const float kOctreeOwn = 0.15f;

struct OctreeNode {
  int node;  // -1: nothing is there
  int level;
};

// A descent from the root towards a cell of some level.
struct OctreeDescent {
  int node;   // present node; -1: nothing is there
  uint word;  // of that node
  int shift;  // levels still to descend; 0 or a leaf: the descent has ended
};

MAQUETTE_FN OctreeDescent octree_root(int level) {
  OctreeDescent d;
  d.node = 0;
  d.word = octree_word(0);
  d.shift = level;
  return d;
}

// Towards the cell at these integer coordinates, until `shift` levels are left.
MAQUETTE_FN OctreeDescent octree_descend(OctreeDescent from, ivec3 cell, int shift) {
  OctreeDescent d = from;
  bool going = d.node >= 0 && d.shift > shift && (d.word >> 24u) != 0u;
  while (going) {
    --d.shift;
    ivec3 bits = (cell >> d.shift) & 1;
    int child = bits.x | (bits.y << 1) | (bits.z << 2);
    uint upto = (d.word >> 24u) & ((2u << uint(child)) - 1u);
    bool there = (upto >> uint(child)) != 0u;
    d.node = there ? int(d.word & 0xffffffu) + bitCount(upto) - 1 : -1;
    // Words of the last level are planes.
    going = there && d.shift > shift;
    if (there && d.shift > 0) d.word = octree_word(d.node);
    going = going && (d.word >> 24u) != 0u;
  }
  return d;
}

// The node of `level` at these integer coordinates (in cells of that level), or the leaf that contains it; `from`: the root, or a descent
// that has begun on the same path.
MAQUETTE_FN OctreeNode octree_node_at(OctreeDescent from, ivec3 cell, int level) {
  int end = (1 << level) - 1;
  ivec3 outside = cell | (ivec3(end) - cell);
  OctreeDescent d = octree_descend(from, cell, 0);
  OctreeNode at;
  at.node = (outside.x | outside.y | outside.z) >= 0 ? d.node : -1;
  at.level = level - d.shift;
  return at;
}

// The common part of the descents to `lowest` and to the seven cells next to it along x, y and z.
MAQUETTE_FN OctreeDescent octree_common(ivec3 lowest, int level) {
  ivec3 change = lowest ^ (lowest + ivec3(1));
  bool outside = (lowest.x | lowest.y | lowest.z) < 0;
  int apart = outside ? level : min(findMSB(change.x | change.y | change.z) + 1, level);
  return octree_descend(octree_root(level), lowest, apart);
}

struct OctreeSurface {
  vec3 normal;  // unit; a rim may face away from the ray by up to kOctreeBack and more
  int material;
  vec3 tint;
};

// Trilinear among the means of the eight cells around `point` that are not empty, weighted by coverage. The material is that with the largest
// weight, and only cells of this material on the same side of an edge are averaged. So edges between materials run smoothly through cells, and a
// cell with a corner of its neighbours' material does not stand out.
// Source: Knutsson and Westin 1993, "Normalized and Differential Convolution", Sec. 2, for means with missing values.
MAQUETTE_FN OctreeSurface octree_surface(OctreeFrame tree, OctreeHit hit, vec3 point, vec3 direction) {
  float cells_per_m = tree.cells_per_m / float(1 << (tree.depth - hit.level));
  vec3 g = (point - tree.corner) * cells_per_m - vec3(0.5f);
  vec3 low = floor(g), f = g - low;
  float weights[8];
  uint colors[8];
  vec3 normals[8];
  OctreeColor own = octree_unpack_color(octree_color_word(hit.node));
  uint word = octree_word(hit.node);
  vec3 own_normal = octree_unpack_plane(hit.level == tree.depth ? word : octree_plane_word(hit.node)).normal;
  own_normal = own_normal * (1.0f / sqrt(dot(own_normal, own_normal)));
  // A leaf that was not subdivided has one material (cells of several are subdivided) and keeps it: others around may be hidden behind it.
  bool pure = hit.level < tree.depth && hit.level >= tree.depth - tree.detail && (word >> 24u) == 0u;
  bool rim = dot(own_normal, direction) <= kOctreeBack;
  float of_own = 0.0f, most = 0.0f;
  int other = own.material;
  ivec3 lowest = ivec3(low);
  OctreeDescent shared_walk = octree_common(lowest, hit.level);
  // Descents of different length need a loop that is not unrolled. Its results are stored without computed indices, which
  // software devices process separately for each invocation.
  int nodes[8], levels[8];
  for (int k = 0; k < 8; ++k) {
    OctreeNode at = octree_node_at(shared_walk, lowest + ivec3(k & 1, (k >> 1) & 1, k >> 2), hit.level);
    for (int j = 0; j < 8; ++j) {
      nodes[j] = j == k ? at.node : nodes[j];
      levels[j] = j == k ? at.level : levels[j];
    }
  }
  for (int k = 0; k < 8; ++k) {
    vec3 w = mix(vec3(1.0f) - f, f, vec3(ivec3(k & 1, (k >> 1) & 1, k >> 2)));
    weights[k] = 0.0f;
    colors[k] = 0u;
    normals[k] = vec3(0.0f);
    if (nodes[k] >= 0) {
      colors[k] = octree_color_word(nodes[k]);
      vec3 n = octree_unpack_plane(levels[k] == tree.depth ? octree_word(nodes[k]) : octree_plane_word(nodes[k])).normal;
      normals[k] = n * (1.0f / sqrt(dot(n, n)));
      weights[k] = w.x * w.y * w.z * (octree_unpack_color(colors[k]).coverage + 0.05f);
      int material = int(colors[k] & 4095u);
      if (material == own.material) {
        of_own += weights[k];
        rim = rim || (dot(normals[k], direction) < 0.0f && dot(normals[k], own_normal) > kOctreeSameSide);
      } else if (weights[k] > most) {
        most = weights[k];
        other = material;
      }
    }
  }
  // A normal that faces away belongs to the rim of a curved surface or, if no cell around faces the ray, to the back of a sheet.
  own_normal = rim ? own_normal : vec3(0.0f) - own_normal;
  float of_other = 0.0f;
  for (int k = 0; k < 8; ++k) {
    normals[k] = dot(normals[k], own_normal) < 0.0f ? vec3(0.0f) - normals[k] : normals[k];
    of_other += int(colors[k] & 4095u) == other ? weights[k] : 0.0f;
  }
  OctreeSurface surface;
  surface.material = other != own.material && !pure && of_other > of_own ? other : own.material;
  // If that is another material than the cell's own, the cell of it with the largest weight defines the side.
  vec3 side = own_normal;
  most = 0.0f;
  for (int k = 0; k < 8; ++k) {
    bool nearer = surface.material != own.material && int(colors[k] & 4095u) == surface.material && weights[k] > most;
    most = nearer ? weights[k] : most;
    side = nearer ? normals[k] : side;
  }
  float least = pure ? kOctreeOwn : 1.0e-4f;
  vec3 normal = least * side;
  vec3 tint = least * own.tint;
  float sum = least;
  for (int k = 0; k < 8; ++k) {
    bool counts = int(colors[k] & 4095u) == surface.material && dot(normals[k], side) > kOctreeSameSide;
    float weight = counts ? weights[k] : 0.0f;
    normal = normal + weight * normals[k];
    tint = tint + weight * octree_unpack_color(colors[k]).tint;
    sum += weight;
  }
  surface.normal = normal * (1.0f / sqrt(dot(normal, normal)));
  surface.tint = tint * (1.0f / sum);
  return surface;
}
