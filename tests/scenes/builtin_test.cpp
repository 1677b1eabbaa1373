#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "scenes/brdf.h"
#include "scenes/error.h"
#include "scenes/modelling.h"
#include "scenes/scene.h"
#include "scenes/subdivision.h"

namespace maquette {
namespace {

class BuiltinScene : public testing::TestWithParam<const char*> {};

TEST_P(BuiltinScene, IndicesAndAttributesAreValid) {
  const Scene scene = build_builtin_scene(GetParam());
  EXPECT_EQ(scene.name, "builtin:" + std::string(GetParam()));
  EXPECT_FALSE(scene.cameras.empty());
  EXPECT_EQ(scene.roots.size(), scene.nodes.size());
  for (const Mesh& mesh : scene.meshes) {
    for (const Primitive& p : mesh.primitives) {
      ASSERT_FALSE(p.indices.empty()) << mesh.name;
      ASSERT_EQ(p.indices.size() % 3, 0u);
      ASSERT_EQ(p.normals.size(), p.positions.size()) << mesh.name;
      ASSERT_TRUE(p.uvs[0].empty() || p.uvs[0].size() == p.positions.size()) << mesh.name;
      ASSERT_GE(p.material, 0) << mesh.name;
      ASSERT_LT(p.material, static_cast<int>(scene.materials.size()));
      for (const std::uint32_t i : p.indices) ASSERT_LT(i, p.positions.size()) << mesh.name;
      for (std::size_t i = 0; i < p.positions.size(); ++i) {
        ASSERT_TRUE(std::isfinite(glm::dot(p.positions[i], p.positions[i]))) << mesh.name;
        ASSERT_NEAR(glm::length(p.normals[i]), 1.0f, 1e-3f) << mesh.name;
      }
    }
  }
}

TEST(Modelling, LongEdgesAreSplitWithoutCracks) {
  Primitive box = modelling::make_rounded_box({5.6, 0.2, 3.6}, 0.05, 4);
  const auto area_of = [](const Primitive& p) {
    double area = 0.0;
    for (std::size_t i = 0; i < p.indices.size(); i += 3) {
      const glm::dvec3 a(p.positions[p.indices[i]]), b(p.positions[p.indices[i + 1]]), c(p.positions[p.indices[i + 2]]);
      area += 0.5 * glm::length(glm::cross(b - a, c - a));
    }
    return area;
  };
  /// Edges by their ends' positions, which of a closed surface each have as many triangles on one side as on the other.
  const auto open_edges = [](const Primitive& p) {
    std::map<std::array<float, 6>, int> sides;
    for (std::size_t i = 0; i < p.indices.size(); ++i) {
      const glm::vec3 a = p.positions[p.indices[i]], b = p.positions[p.indices[i % 3 == 2 ? i - 2 : i + 1]];
      ++sides[{a.x, a.y, a.z, b.x, b.y, b.z}];
      --sides[{b.x, b.y, b.z, a.x, a.y, a.z}];
    }
    return std::count_if(sides.begin(), sides.end(), [](const auto& side) { return side.second != 0; });
  };
  const double area = area_of(box);
  const auto open = open_edges(box);
  modelling::split_long_edges(&box, 0.2);
  EXPECT_NEAR(area_of(box), area, 1e-5 * area);
  EXPECT_EQ(open_edges(box), open);
  for (std::size_t i = 0; i < box.indices.size(); ++i)
    ASSERT_LE(glm::distance(box.positions[box.indices[i]], box.positions[box.indices[i % 3 == 2 ? i - 2 : i + 1]]),
              0.2001f);
}

TEST_P(BuiltinScene, NormalsAgreeWithTheWinding) {
  const Scene scene = build_builtin_scene(GetParam());
  for (const Mesh& mesh : scene.meshes) {
    for (const Primitive& p : mesh.primitives) {
      double agreeing = 0.0, total = 0.0;
      std::size_t degenerate = 0;
      for (std::size_t i = 0; i < p.indices.size(); i += 3) {
        const std::uint32_t a = p.indices[i], b = p.indices[i + 1], c = p.indices[i + 2];
        const glm::vec3 area = glm::cross(p.positions[b] - p.positions[a], p.positions[c] - p.positions[a]);
        const double size = glm::length(area);
        if (size < 1e-12) ++degenerate;
        total += size;
        if (glm::dot(area, p.normals[a] + p.normals[b] + p.normals[c]) > 0.0f) agreeing += size;
      }
      // Rims at sharp corners of an outline may overlap themselves; larger overlaps are errors.
      EXPECT_GT(agreeing, 0.99 * total) << mesh.name;
      EXPECT_LT(static_cast<double>(degenerate), 0.01 * static_cast<double>(p.indices.size() / 3) + 1.0) << mesh.name;
    }
  }
}

TEST_P(BuiltinScene, IsTheSameEveryTime) {
  const Scene a = build_builtin_scene(GetParam()), b = build_builtin_scene(GetParam());
  ASSERT_EQ(a.meshes.size(), b.meshes.size());
  for (std::size_t i = 0; i < a.meshes.size(); ++i) {
    ASSERT_EQ(a.meshes[i].primitives.size(), b.meshes[i].primitives.size());
    for (std::size_t j = 0; j < a.meshes[i].primitives.size(); ++j) {
      const Primitive &p = a.meshes[i].primitives[j], &q = b.meshes[i].primitives[j];
      ASSERT_EQ(p.positions.size(), q.positions.size());
      EXPECT_EQ(std::memcmp(p.positions.data(), q.positions.data(), p.positions.size() * sizeof(glm::vec3)), 0);
      EXPECT_EQ(p.indices, q.indices);
    }
  }
  ASSERT_EQ(a.images.size(), b.images.size());
  for (std::size_t i = 0; i < a.images.size(); ++i) EXPECT_EQ(a.images[i].rgba, b.images[i].rgba);
}

TEST_P(BuiltinScene, NamesAreUnique) {
  const Scene scene = build_builtin_scene(GetParam());
  std::set<std::string> names;
  for (const Material& material : scene.materials) EXPECT_TRUE(names.insert(material.name).second) << material.name;
  names.clear();
  for (const Node& node : scene.nodes) EXPECT_TRUE(names.insert(node.name).second) << node.name;
}

INSTANTIATE_TEST_SUITE_P(All, BuiltinScene,
                         testing::Values("sphere", "plate", "cornell", "seat", "open-seat", "cockpit"),
                         [](const auto& instance) {
                           std::string name(instance.param);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(BuiltinScenes, UnknownNameListsTheKnownOnes) {
  try {
    build_builtin_scene("car");
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("sphere"), std::string::npos);
  }
}

TEST(BuiltinScenes, SphereIsAUnitSphereWithExactNormals) {
  const Scene scene = build_builtin_scene("sphere");
  ASSERT_EQ(scene.meshes.size(), 1u);
  const Primitive& p = scene.meshes[0].primitives[0];
  for (std::size_t i = 0; i < p.positions.size(); ++i) {
    ASSERT_NEAR(glm::length(p.positions[i]), 1.0f, 1e-6f);
    ASSERT_LT(glm::length(p.positions[i] - p.normals[i]), 1e-6f);
  }
  ASSERT_EQ(scene.materials.size(), 1u);
  EXPECT_EQ(scene.materials[0].name, "Sphere");
  EXPECT_EQ(scene.materials[0].measured, "builtin:paint-red-metallic");
}

TEST(BuiltinScenes, CornellLightFacesDown) {
  const Scene scene = build_builtin_scene("cornell");
  bool found = false;
  for (const Mesh& mesh : scene.meshes) {
    const Primitive& p = mesh.primitives[0];
    if (scene.materials[static_cast<std::size_t>(p.material)].emissive.x <= 0.0f) continue;
    found = true;
    for (const glm::vec3& normal : p.normals) EXPECT_LT(normal.y, -0.99f);
  }
  EXPECT_TRUE(found);
}

const Node& node_named(const Scene& scene, const std::string& name) {
  for (const Node& node : scene.nodes)
    if (node.name == name) return node;
  throw UsageError(name, "no such node");
}

const Mesh& mesh_named(const Scene& scene, const std::string& name) {
  return scene.meshes.at(static_cast<std::size_t>(node_named(scene, name).mesh));
}

TEST(Cockpit, HasTheCamerasVariantsAndMaterialsOfTheContract) {
  const Scene scene = build_builtin_scene("cockpit");
  std::set<std::string> cameras;
  for (const Camera& camera : scene.cameras) cameras.insert(camera.name);
  EXPECT_EQ(cameras, (std::set<std::string>{"driver", "passenger", "exterior", "door"}));
  EXPECT_EQ(scene.variants.size(), 3u);
  const std::set<std::string> library = [] {
    std::set<std::string> names;
    for (const BuiltinBrdf& brdf : builtin_brdfs()) names.insert("builtin:" + brdf.name);
    return names;
  }();
  int measured = 0, analytic = 0, panes = 0, emitters = 0;
  for (const Material& material : scene.materials) {
    EXPECT_TRUE(material.measured.empty() || library.contains(material.measured)) << material.measured;
    (material.measured.empty() ? analytic : measured) += 1;
    panes += material.transmission == 1.0f ? 1 : 0;
    emitters += glm::length(material.emissive) > 0.0f ? 1 : 0;
  }
  EXPECT_GE(measured, 16);
  EXPECT_GE(analytic, 4);
  EXPECT_GE(panes, 1);
  EXPECT_GE(emitters, 3);
}

TEST(Cockpit, VariantsChangePaintAndTrim) {
  const Scene scene = build_builtin_scene("cockpit");
  for (const char* name : {"hood", "door_front_left", "seat_driver_cushion", "dashboard_lower", "dashboard_decor"}) {
    const Primitive& p = mesh_named(scene, name).primitives[0];
    std::set<std::string> measured;
    for (int variant = 0; variant < 3; ++variant) {
      const int material = material_of(p, variant);
      ASSERT_GE(material, 0);
      measured.insert(scene.materials.at(static_cast<std::size_t>(material)).measured);
    }
    EXPECT_EQ(measured.size(), 3u) << name;
    EXPECT_EQ(material_of(p, 0), p.material) << name;
  }
}

TEST(Cockpit, IsLifeSizeAndSymmetricEnough) {
  Scene scene = build_builtin_scene("cockpit");
  for (Node& node : scene.nodes)
    if (node.name == "ground") node.visible = false;
  const Bounds bounds = compute_bounds(scene);
  const glm::vec3 size = bounds.max - bounds.min;
  EXPECT_NEAR(size.z, 4.4f, 0.15f);
  EXPECT_NEAR(size.y, 1.38f, 0.06f);
  EXPECT_NEAR(bounds.min.y, 0.0f, 0.005f) << "the tyres stand on the ground";
  EXPECT_NEAR(bounds.min.x, -bounds.max.x, 0.002f);
  const Primitive& body = mesh_named(scene, "body").primitives[0];
  float half = 0.0f;
  for (const glm::vec3& p : body.positions) half = std::max(half, p.x);
  EXPECT_NEAR(half, 0.925f, 0.03f) << "1.85 m without mirrors";
  const std::size_t triangles = count_triangles(scene);
  EXPECT_GT(triangles, 150'000u);
  EXPECT_LT(triangles, 400'000u);
}

TEST(Cockpit, WindshieldIsConvexOutsideWithItsRake) {
  const Scene scene = build_builtin_scene("cockpit");
  ASSERT_EQ(scene.patches.size(), 2u);  // and the interior mirror
  const BezierPatch& patch = scene.patches[0];
  EXPECT_TRUE(patch.reflector);
  EXPECT_EQ(scene.materials.at(static_cast<std::size_t>(patch.material)).transmission, 1.0f);
  const Primitive surface = tessellate_patch(patch, 16);
  const std::size_t middle = surface.positions.size() / 2;
  const glm::vec3 normal = surface.normals[middle];
  EXPECT_GT(normal.y, 0.0f);
  EXPECT_GT(normal.z, 0.0f) << "the outside faces forwards and up";
  // In the middle plane the pane's tangent leans from the vertical as its normal leans from the horizontal.
  EXPECT_NEAR(glm::degrees(std::atan2(normal.y, normal.z)), 60.0f, 5.0f);
  for (std::size_t i = 0; i < surface.positions.size(); ++i)
    for (std::size_t j = 0; j < surface.positions.size(); j += 7)
      ASSERT_LE(glm::dot(surface.positions[j] - surface.positions[i], surface.normals[i]), 1e-5f);
}

TEST(Cockpit, DoorSkinFacesOutwardsAndDents) {
  const Scene scene = build_builtin_scene("cockpit");
  for (const auto& [name, side] : {std::pair{"door_front_left", 1.0f}, std::pair{"door_front_right", -1.0f}}) {
    const Mesh& mesh = mesh_named(scene, name);
    ASSERT_TRUE(mesh.cage);
    double facing = 0.0;
    for (const glm::vec3& normal : mesh.primitives[0].normals) facing += side * normal.x;
    EXPECT_GT(facing, 0.6 * static_cast<double>(mesh.primitives[0].normals.size())) << name;
    SubdivisionCage cage = *mesh.cage;
    const glm::vec3 centre(side * 0.88f, 0.55f, 0.0f);
    EXPECT_GE(dent_cage(&cage, centre, {-side, 0.0f, 0.0f}, 0.03f, 0.15f), 12);
    Mesh dented = mesh;
    dented.cage = std::make_shared<const SubdivisionCage>(cage);
    tessellate_cage(&dented);
    float deepest = 0.0f;
    for (std::size_t i = 0; i < dented.primitives[0].positions.size(); ++i)
      deepest = std::max(deepest, glm::length(dented.primitives[0].positions[i] - mesh.primitives[0].positions[i]));
    EXPECT_GT(deepest, 0.015f) << name;
    EXPECT_LT(deepest, 0.031f) << name;
  }
}

TEST(Cockpit, DriverSitsInTheCabinWithAClearView) {
  const Scene scene = build_builtin_scene("cockpit");
  const glm::vec3 seat(node_named(scene, "r_point").local[3]), eye(node_named(scene, "driver").local[3]);
  EXPECT_NEAR(eye.y - seat.y, 0.63f, 0.05f);
  EXPECT_GT(eye.x, 0.2f) << "left-hand drive, +X is left";
  // Nothing within 15 cm of the eye.
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    if (scene.nodes[i].mesh < 0) continue;
    for (const glm::vec3& p : scene.meshes[static_cast<std::size_t>(scene.nodes[i].mesh)].primitives[0].positions)
      ASSERT_GT(glm::length(glm::vec3(world[i] * glm::vec4(p, 1.0f)) - eye), 0.15f) << scene.nodes[i].name;
  }
}

TEST(Cockpit, SurvivesSavingAndLoading) {
  const Scene scene = build_builtin_scene("cockpit");
  const std::string path = (std::filesystem::temp_directory_path() / "maquette_cockpit_test.glb").string();
  save_glb(path, scene);
  const Scene loaded = load_gltf(path);
  std::filesystem::remove(path);
  EXPECT_EQ(loaded.nodes.size(), scene.nodes.size());
  EXPECT_EQ(loaded.materials.size(), scene.materials.size());
  EXPECT_EQ(loaded.cameras.size(), scene.cameras.size());
  EXPECT_EQ(loaded.patches.size(), scene.patches.size());
  EXPECT_EQ(loaded.variants, scene.variants);
  EXPECT_EQ(count_triangles(loaded), count_triangles(scene));
  EXPECT_TRUE(mesh_named(loaded, "door_front_left").cage);
  EXPECT_LT(glm::length(compute_bounds(loaded).max - compute_bounds(scene).max), 1e-4f);
}

/// What the bake of surface light fields relies on: the lamp fills several bins of a lumisphere, and the seat's parts
/// lie in the box.
TEST(BuiltinScenes, TheSeatStandsInABoxBelowItsLamp) {
  const Scene scene = build_builtin_scene("seat");
  const auto bounds_of = [&](const char* name) {
    Bounds bounds;
    const int mesh = node_named(scene, name).mesh;
    for (const glm::vec3& p : scene.meshes[static_cast<std::size_t>(mesh)].primitives[0].positions)
      bounds.min = glm::min(bounds.min, p), bounds.max = glm::max(bounds.max, p);
    return bounds;
  };
  const Bounds lamp = bounds_of("lamp"), cushion = bounds_of("seat_cushion"), back = bounds_of("seat_backrest");
  const Bounds floor = bounds_of("floor"), ceiling = bounds_of("ceiling");
  EXPECT_NEAR(lamp.max.y, ceiling.min.y, 0.02f);
  for (const Bounds& part : {cushion, back}) {
    EXPECT_GT(part.min.x, floor.min.x);
    EXPECT_LT(part.max.x, floor.max.x);
    EXPECT_GT(part.min.z, floor.min.z);
    EXPECT_GT(part.min.y, floor.min.y);
    EXPECT_LT(part.max.y, ceiling.min.y);
  }
  const glm::vec3 from(cushion.center().x, cushion.max.y, cushion.center().z);
  for (const glm::vec3& edge :
       {glm::vec3(lamp.min.x, lamp.min.y, lamp.center().z), glm::vec3(lamp.center().x, lamp.min.y, lamp.max.z)}) {
    const float cosine = glm::dot(glm::normalize(edge - from), glm::normalize(lamp.center() - from));
    EXPECT_GT(glm::degrees(std::acos(cosine)), 12.0f);
  }
  EXPECT_TRUE(node_named(scene, "mirror_wall").reflector);
}

}  // namespace
}  // namespace maquette
