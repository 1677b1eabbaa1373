// Models and the exact octree of the tests of the octree.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "render/octree/octree_build.h"
#include "render/octree/octree_clip.h"
#include "render/octree/octree_shared.h"
#include "scenes/error.h"

namespace maquette::test {

/// The same source in double.
namespace exact {
using namespace glm;
using shared::octree_plane_word;
using shared::octree_word;
inline double max(double a, double b) { return std::max(a, b); }
inline double min(double a, double b) { return std::min(a, b); }
inline double clamp(double v, double low, double high) { return std::clamp(v, low, high); }
inline int clamp(int v, int low, int high) { return std::clamp(v, low, high); }
#define float double
#define vec3 dvec3
#include "shared/octree.glsl"
#undef float
#undef vec3
}  // namespace exact

/// Owns the inputs of an OctreeSource.
struct Model {
  Scene scene;
  FlatGeometry geometry;
  std::vector<int> materials;
  std::vector<bool> transmits;
  std::unique_ptr<OctreeTextures> textures;

  explicit Model(Scene s) : scene(std::move(s)) {
    geometry = flatten(scene);
    for (const DrawItem& item : geometry.items) {
      materials.push_back(item.patch >= 0 ? scene.patches[static_cast<std::size_t>(item.patch)].material
                                          : scene.meshes[static_cast<std::size_t>(item.mesh)]
                                                .primitives[static_cast<std::size_t>(item.primitive)]
                                                .material);
      const int m = materials.back();
      transmits.push_back(m >= 0 && scene.materials[static_cast<std::size_t>(m)].glass);
    }
    textures = std::make_unique<OctreeTextures>(scene, scene.materials);
  }
  OctreeSource source() const { return {geometry, materials, transmits, *textures}; }
  double area() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < geometry.items.size(); ++i) {
      if (transmits[i]) continue;
      const DrawItem& item = geometry.items[i];
      for (std::size_t k = item.first_index; k < item.first_index + item.index_count; k += 3) {
        const glm::dvec3 a = geometry.positions[geometry.indices[k]], b = geometry.positions[geometry.indices[k + 1]],
                         c = geometry.positions[geometry.indices[k + 2]];
        sum += 0.5 * glm::length(glm::cross(b - a, c - a));
      }
    }
    return sum;
  }
};

inline Scene scene_of(const Primitive& primitive) {
  Scene scene;
  scene.meshes.push_back({"mesh", {primitive}, nullptr});
  Node node;
  node.mesh = 0;
  scene.nodes.push_back(node);
  scene.roots = {0};
  return scene;
}

/// Random triangles of all sizes, and axis-parallel ones in the planes of the grid.
inline Scene soup(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> u(-1.0f, 1.0f);
  Primitive p;
  p.material = 0;
  for (int i = 0; i < count; ++i) {
    const glm::vec3 center(u(random), u(random), u(random));
    const float size = std::exp2(-4.0f + 3.5f * u(random));
    for (int k = 0; k < 3; ++k) {
      glm::vec3 q = center + size * glm::vec3(u(random), u(random), u(random));
      if (i % 8 == 0) q[i / 8 % 3] = std::round(center[i / 8 % 3] * 8.0f) / 8.0f;
      p.indices.push_back(static_cast<std::uint32_t>(p.positions.size()));
      p.positions.push_back(glm::clamp(q, -1.0f, 1.0f));
    }
  }
  Scene scene = scene_of(p);
  scene.materials.emplace_back();
  return scene;
}

inline double total_area(const OctreeBricks& bricks) {
  double sum = 0.0;
  for (const auto& [code, entry] : bricks.bricks) sum += entry.brick.sums.area;
  const double cells_per_m = std::exp2(bricks.grid.depth) / bricks.grid.side_m;
  return sum / (cells_per_m * cells_per_m);
}

struct Box {
  glm::dvec3 low{}, high{};
  std::uint32_t node;
  int level;
};

inline std::vector<Box> leaf_boxes(const Octree& octree) {
  std::vector<Box> boxes;
  for (const OctreeCell& leaf : list_leaves(octree)) {
    const double cell = std::exp2(octree.depth - leaf.level);
    const glm::dvec3 low = glm::dvec3(leaf.coordinate) * cell;
    boxes.push_back({low, low + cell, leaf.node, leaf.level});
  }
  return boxes;
}

/// A floor at y = 0.3 over [0, 1]^2 of two materials, with a border from `x0` at z = 0 to `x1` at z = 1.
inline Octree two_materials(float x0, float x1, int depth) {
  Primitive left, right;
  left.positions = {{0, 0.3f, 0}, {x0, 0.3f, 0}, {x1, 0.3f, 1}, {0, 0.3f, 1}};
  right.positions = {{x0, 0.3f, 0}, {1, 0.3f, 0}, {1, 0.3f, 1}, {x1, 0.3f, 1}};
  left.indices = right.indices = {0, 1, 2, 0, 2, 3};
  left.material = 0;
  right.material = 1;
  Scene scene = scene_of(left);
  scene.meshes[0].primitives.push_back(right);
  scene.materials.resize(2);
  const Model model(std::move(scene));
  OctreeOptions options;
  options.depth = depth;
  return build_octree(model.source(), options);
}

/// Two plates that meet at a right angle, one of them half of another material and with a stripe of another colour.
inline Scene plates() {
  const auto quad = [](const glm::vec3& o, const glm::vec3& a, const glm::vec3& b, int material, float shade) {
    Primitive p;
    p.positions = {o, o + a, o + a + b, o + b};
    p.colors.assign(4, glm::vec4(glm::vec3(shade), 1.0f));
    p.indices = {0, 1, 2, 0, 2, 3};
    p.material = material;
    return p;
  };
  Scene scene = scene_of(quad({0, 0, 0}, {0.4f, 0, 0}, {0, 0, 1}, 0, 0.8f));
  auto& all = scene.meshes[0].primitives;
  all.push_back(quad({0.4f, 0, 0}, {0.31f, 0, 0}, {0, 0, 1}, 1, 0.8f));
  all.push_back(quad({0.71f, 0, 0}, {0.01f, 0, 0}, {0, 0, 1}, 1, 0.1f));
  all.push_back(quad({0.72f, 0, 0}, {0.28f, 0, 0}, {0, 0, 1}, 1, 0.8f));
  all.push_back(quad({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 0, 0.8f));
  scene.materials.resize(2);
  return scene;
}

}  // namespace maquette::test
