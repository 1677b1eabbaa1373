// Which node a click makes a reflector.
#include "viewer/reflector_picking.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "render/reflections/reflectors.h"
#include "scenes/error.h"
#include "scenes/node_paths.h"

namespace maquette {
namespace {

int node_named(const Scene& scene, const std::string& name) {
  for (std::size_t i = 0; i < scene.nodes.size(); ++i)
    if (scene.nodes[i].name == name) return static_cast<int>(i);
  ADD_FAILURE() << name;
  return -1;
}

TEST(ReflectorPicking, FindsTheNearestSurfaceThatMirrors) {
  const Scene scene = build_builtin_scene("cockpit");
  Edits edits;
  const glm::vec3 eye(0.37f, 1.13f, -0.05f), out(1.0f, -0.12f, 0.3f);
  const int glass = find_mirror(scene, edits, eye, glm::normalize(out), 1e30f);
  ASSERT_GE(glass, 0);
  EXPECT_EQ(scene.nodes[static_cast<std::size_t>(glass)].name, "side_glass_left");
  EXPECT_EQ(find_mirror(scene, edits, eye, glm::normalize(out), 0.1f), -1) << "behind what is opaque";
  const int windshield = find_mirror(scene, edits, eye, {0.0f, 0.0f, 1.0f}, 1e30f);
  ASSERT_GE(windshield, 0);
  EXPECT_GE(scene.nodes[static_cast<std::size_t>(windshield)].patch, 0);
  edits.hidden_nodes.insert(node_paths(scene)[static_cast<std::size_t>(glass)]);
  EXPECT_NE(find_mirror(scene, edits, eye, glm::normalize(out), 1e30f), glass) << "what is hidden";
}

TEST(ReflectorPicking, AClickAddsAndAClickTakesAway) {
  const Scene scene = build_builtin_scene("cockpit");
  Edits edits;
  const std::set<int> marked = reflecting_nodes(scene, edits);
  EXPECT_EQ(marked.size(), 2u);
  const int glass = node_named(scene, "side_glass_left");
  ASSERT_TRUE(toggle_reflector(scene, glass, &edits));
  EXPECT_EQ(reflecting_nodes(scene, edits).size(), 3u);
  EXPECT_TRUE(reflecting_nodes(scene, edits).contains(glass));
  for (const int node : marked) EXPECT_TRUE(toggle_reflector(scene, node, &edits));
  EXPECT_EQ(reflecting_nodes(scene, edits), std::set<int>{glass});
  const Edits before = edits;
  EXPECT_FALSE(toggle_reflector(scene, glass, &edits)) << "the last one stays";
  EXPECT_EQ(edits, before);
}

/// The picture and the panel agree on what reflects.
TEST(ReflectorPicking, AgreesWithTheRenderer) {
  Scene scene = build_builtin_scene("cockpit");
  // A pane with a frame of rubber in the same node.
  Mesh& mesh = scene.meshes[static_cast<std::size_t>(
      scene.nodes[static_cast<std::size_t>(node_named(scene, "side_glass_left"))].mesh)];
  mesh.primitives.push_back(mesh.primitives.front());
  mesh.primitives.back().material = static_cast<int>(scene.materials.size());
  scene.materials.emplace_back().name = "Rubber seal";
  const FlatGeometry geometry = flatten(scene);
  std::vector<const Material*> materials;
  const Material none;
  for (const DrawItem& item : geometry.items) {
    int index = item.patch >= 0 ? scene.patches[static_cast<std::size_t>(item.patch)].material : -1;
    if (item.mesh >= 0)
      index = material_of(
          scene.meshes[static_cast<std::size_t>(item.mesh)].primitives[static_cast<std::size_t>(item.primitive)], -1);
    materials.push_back(index >= 0 ? &scene.materials[static_cast<std::size_t>(index)] : &none);
  }
  for (const std::set<std::string>& names : {std::set<std::string>{}, {"side_glass_left", "rear_glass"}}) {
    Edits edits;
    edits.reflectors = names;
    std::set<int> drawn;
    for (const Reflector& r : find_reflectors(scene, geometry, materials, {names.begin(), names.end()}))
      drawn.insert(r.node);
    EXPECT_EQ(reflecting_nodes(scene, edits), drawn);
  }
  const auto dull = std::find_if(scene.nodes.begin(), scene.nodes.end(), [&](const Node& node) {
    if (node.mesh < 0) return false;
    const auto& primitives = scene.meshes[static_cast<std::size_t>(node.mesh)].primitives;
    return std::none_of(primitives.begin(), primitives.end(), [&](const Primitive& p) {
      return p.material >= 0 && can_mirror(scene.materials[static_cast<std::size_t>(p.material)]);
    });
  });
  ASSERT_NE(dull, scene.nodes.end());
  try {
    find_reflectors(scene, geometry, materials, {"side_glass_left", dull->name});
    ADD_FAILURE() << dull->name << " mirrors nothing";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("neither glass nor a smooth metal"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace maquette
