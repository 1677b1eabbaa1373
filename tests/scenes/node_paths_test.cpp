#include "scenes/node_paths.h"

#include <gtest/gtest.h>

namespace maquette {
namespace {

/// Nodes by name and parent.
Scene tree(const std::vector<std::pair<std::string, int>>& nodes) {
  Scene scene;
  for (const auto& [name, parent] : nodes) {
    Node node;
    node.name = name;
    node.parent = parent;
    scene.nodes.push_back(node);
  }
  return scene;
}

TEST(NodePaths, AreNeverTheSameAndFindTheirNode) {
  // Names with the marks in them, without a name, and the same ones twice.
  const Scene scene = tree({{"car", -1},
                            {"door", 0},
                            {"door", 0},
                            {"door#2", 0},
                            {"car/door", -1},
                            {"", -1},
                            {"", -1},
                            {"", 0},
                            {"a##2", -1},
                            {"a", -1},
                            {"a", -1},
                            {"a#2", -1},
                            {"car", -1}});
  const std::vector<std::string> paths = node_paths(scene);
  EXPECT_EQ(paths[0], "/car");
  EXPECT_EQ(paths[1], "/car/door");
  EXPECT_EQ(paths[2], "/car/door#2");
  EXPECT_EQ(paths[3], "/car/door##2");
  EXPECT_EQ(paths[4], "/car/door#3");
  EXPECT_EQ(std::set<std::string>(paths.begin(), paths.end()).size(), paths.size());
  for (std::size_t i = 0; i < paths.size(); ++i)
    EXPECT_EQ(called_nodes(scene, paths, paths[i]), std::vector<int>{static_cast<int>(i)}) << paths[i];
}

TEST(NodePaths, ANameCallsAllThatHaveIt) {
  const Scene scene = tree({{"car", -1}, {"door", 0}, {"door", 0}, {"/car", -1}});
  EXPECT_EQ(called_nodes(scene, {"door"}), (std::set<int>{1, 2}));
  EXPECT_EQ(called_nodes(scene, {"/car/door#2", "car"}), (std::set<int>{0, 2}));
  EXPECT_TRUE(called_nodes(scene, {"none", "/none"}).empty());
}

TEST(NodePaths, VariantsByName) {
  Scene scene;
  scene.variants = {"day", "night"};
  EXPECT_EQ(variant_index(scene, "night"), 1);
  EXPECT_EQ(variant_index(scene, ""), -1);
  EXPECT_EQ(variant_index(scene, "noon"), -1);
}

}  // namespace
}  // namespace maquette
