#include "render/frame/plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <set>

#include "render/reflections/reflectors.h"
#include "render/scene_state/enclosure.h"
#include "render/technique/registry.h"
#include "scenes/error.h"
#include "test_paths.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

/// Among the passes or the features.
bool has_pass(const FramePlan& plan, const std::string& name) {
  const auto is = [&](const auto& entry) { return entry.name == name; };
  return std::any_of(plan.passes.begin(), plan.passes.end(), is) ||
         std::any_of(plan.features.begin(), plan.features.end(), is);
}

bool leaves_out(const FramePlan& plan, const std::string& what) {
  for (const LeftOut& left_out : plan.left_out)
    if (left_out.what == what) return true;
  return false;
}

/// A quad with its front towards `normal`, `size` wide, as one node of the scene.
void add_quad(Scene* scene, const glm::vec3& center, const glm::vec3& normal, float size, int material) {
  const glm::vec3 helper = std::abs(normal.y) < 0.9f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0);
  const glm::vec3 u = 0.5f * size * glm::normalize(glm::cross(helper, normal));
  const glm::vec3 v = 0.5f * size * glm::normalize(glm::cross(normal, u));
  Primitive primitive;
  primitive.positions = {center - u - v, center + u - v, center + u + v, center - u + v};
  primitive.indices = {0, 1, 2, 0, 2, 3};
  primitive.material = material;
  Mesh mesh;
  mesh.primitives = {primitive};
  Node node;
  node.mesh = static_cast<int>(scene->meshes.size());
  scene->meshes.push_back(mesh);
  scene->roots.push_back(static_cast<int>(scene->nodes.size()));
  scene->nodes.push_back(node);
}

/// Six quads of a 2 m cube around the origin; `inward`: seen from inside (a room), else a solid. The roof has
/// material 1.
Scene make_box(bool inward) {
  Scene scene;
  scene.materials.resize(2);
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {-1.0f, 1.0f}) {
      glm::vec3 n(0.0f);
      n[axis] = sign;
      add_quad(&scene, n, inward ? -n : n, 2.0f, axis == 1 && sign > 0 ? 1 : 0);
    }
  }
  return scene;
}

TEST(Enclosure, RoomSolidAndOpenGround) {
  EXPECT_NEAR(covered_share(make_box(true), -1, glm::vec3(0.1f, 0.2f, -0.1f)), 1.0, 1e-9);
  EXPECT_EQ(covered_share(make_box(false), -1, glm::vec3(0.0f)), 0.0);  // inside a solid: only back faces
  Scene ground;
  ground.materials.resize(1);
  add_quad(&ground, glm::vec3(0.0f), glm::vec3(0, 1, 0), 1000.0f, 0);
  EXPECT_EQ(covered_share(ground, -1, glm::vec3(0, 1, 0)), 0.0);
  EXPECT_TRUE(is_enclosed(make_box(true), -1));
  EXPECT_FALSE(is_enclosed(make_box(false), -1));
  EXPECT_FALSE(is_enclosed(ground, -1));
  EXPECT_FALSE(is_enclosed(Scene{}, -1));
}

TEST(Enclosure, ARoofCoversItsSolidAngle) {
  Scene roof;
  roof.materials.resize(1);
  add_quad(&roof, glm::vec3(0, 1, 0), glm::vec3(0, -1, 0), 2.0f, 0);
  // A 2 m square 1 m above the eye is one face of the cube: a sixth of the sphere, a third of the hemisphere.
  EXPECT_NEAR(covered_share(roof, -1, glm::vec3(0.0f)), 1.0 / 3.0, 0.002);
  // Twice as wide, source: solid angle of a rectangle, 4 atan(ab / (h sqrt(a^2 + b^2 + h^2))) with half sides a = b
  // = 2.
  Scene wide;
  wide.materials.resize(1);
  add_quad(&wide, glm::vec3(0, 1, 0), glm::vec3(0, -1, 0), 4.0f, 0);
  EXPECT_NEAR(covered_share(wide, -1, glm::vec3(0.0f)), 4.0 * std::atan(4.0 / 3.0) / (2.0 * std::numbers::pi), 0.02);
}

TEST(Enclosure, PanesLetLightThroughAndDoubleSidedWallsDoNot) {
  Scene box = make_box(true);
  box.materials[1].glass = true;
  EXPECT_NEAR(covered_share(box, -1, glm::vec3(0.0f)), 2.0 / 3.0, 0.002);  // the roof was a third
  Scene solid = make_box(false);
  solid.materials[0].double_sided = solid.materials[1].double_sided = true;
  EXPECT_NEAR(covered_share(solid, -1, glm::vec3(0.0f)), 1.0, 1e-9);
  solid.nodes[0].visible = false;
  EXPECT_LT(covered_share(solid, -1, glm::vec3(0.0f)), 0.9);
}

TEST(Enclosure, MirroredNodesKeepTheirFront) {
  Scene box = make_box(true);
  for (Node& node : box.nodes) node.local[0][0] = -1.0f;
  EXPECT_NEAR(covered_share(box, -1, glm::vec3(0.0f)), 1.0, 1e-9);
}

TEST(Facts, CountWhatIsUsedAndVisible) {
  Scene scene = make_box(true);
  scene.materials.resize(4);
  scene.materials[0].measured = "builtin:leather-black";
  scene.materials[1].normal_texture.image = 0;
  scene.materials[2].glass = true;  // used by nothing
  scene.materials[3].emissive = glm::vec3(5.0f);
  scene.meshes[0].primitives[0].variant_materials[1] = 3;
  const SceneFacts facts = compute_facts(scene, -1);
  EXPECT_EQ(facts.triangle_count, 12u);
  EXPECT_EQ(facts.measured_count + facts.analytic_count, 2);
  EXPECT_EQ(facts.measured_count, 1);
  EXPECT_EQ(facts.analytic_count, 1);
  EXPECT_TRUE(facts.has_textures);
  EXPECT_TRUE(facts.has_normal_maps);
  EXPECT_FALSE(facts.has_glass);
  EXPECT_FALSE(facts.has_emissive_meshes);
  EXPECT_TRUE(facts.enclosed);
  EXPECT_TRUE(compute_facts(scene, 1).has_emissive_meshes);
}

TEST(Facts, LobesCountWhereAnAnalyticMaterialHasThem) {
  Scene scene = make_box(true);
  scene.materials[0].sheen_color = glm::vec3(0.1f, 0.0f, 0.0f);
  scene.materials[0].measured = "builtin:leather-black";
  const auto has = [&] {
    const SceneFacts facts = compute_facts(scene, -1);
    const FramePlan made = plan(facts, "uniform", {}, {});
    EXPECT_EQ(made.shading().sheen, !leaves_out(made, "sheen"));
    EXPECT_EQ(made.shading().clearcoat, !leaves_out(made, "clearcoat"));
    return std::pair(made.shading().sheen, made.shading().clearcoat);
  };
  EXPECT_EQ(has(), std::pair(false, false));
  scene.materials[1].sheen_color = glm::vec3(0.0f, 0.0f, 0.1f);
  EXPECT_EQ(has(), std::pair(true, false));
  scene.materials[1].clearcoat = 0.5f;
  EXPECT_EQ(has(), std::pair(true, true));
}

TEST(Plan, VisibilityIsDecidedByTheScene) {
  SceneFacts facts;
  Settings settings;
  EXPECT_EQ(plan(facts, "bandwidth", settings, {}).shading().visibility, "none");
  EXPECT_TRUE(leaves_out(plan(facts, "bandwidth", settings, {}), "visibility"));
  facts.enclosed = true;
  EXPECT_EQ(plan(facts, "bandwidth", settings, {}).shading().visibility, "baked");
  EXPECT_EQ(plan(facts, "uniform", settings, {}).shading().visibility, "baked");
  EXPECT_EQ(plan(facts, "splitsum", settings, {}).shading().visibility, "none");
  settings.set("shading.visibility", std::string("none"));
  EXPECT_EQ(plan(facts, "uniform", settings, {}).shading().visibility, "none");
  facts.enclosed = false;
  settings.set("shading.visibility", std::string("baked"));
  EXPECT_EQ(plan(facts, "uniform", settings, {}).shading().visibility, "baked");
  EXPECT_TRUE(has_pass(plan(facts, "uniform", settings, {}), "visibility"));
}

TEST(Plan, TracedVisibilityWantsAnOctree) {
  Settings traced;
  traced.set("shading.visibility", std::string("traced"));
  for (const char* mode : {"bandwidth", "uniform"}) {
    const FramePlan p = plan({}, mode, traced, {});
    EXPECT_EQ(p.shading().visibility, "traced");
    EXPECT_EQ(plan({}, mode, {}, {}).shading().visibility, "none");
    EXPECT_TRUE(has_pass(p, "octree"));
    EXPECT_FALSE(has_pass(plan({}, mode, {}, {}), "octree"));
  }
}

TEST(Plan, OctreeReflectionsWantAnOctree) {
  ViewInfo view;
  view.reflections = "octree";
  view.reflectors = view.reflectors_in_view = 1;
  const FramePlan p = plan({}, "bandwidth", {}, view);
  EXPECT_EQ(p.reflections, "octree");
  EXPECT_TRUE(has_pass(p, "octree"));
  EXPECT_TRUE(has_pass(p, "rays"));
  EXPECT_EQ(p.shading().visibility, "none");
  view.reflectors_in_view = 0;
  EXPECT_FALSE(has_pass(plan({}, "bandwidth", {}, view), "octree"));
}

TEST(Plan, GlossySurfacesMirrorWhereTheSkyHasShadows) {
  SceneFacts facts;
  facts.enclosed = true;
  facts.least_roughness = 0.1f;
  ViewInfo view;
  view.reflections = "octree";
  Settings settings;
  const auto expect_left_out = [&](const std::string& mode, const std::string& by) {
    const FramePlan p = plan(facts, mode, settings, view);
    EXPECT_FALSE(p.glossy || has_pass(p, "glossy"));
    for (const LeftOut& out : p.left_out)
      if (out.what == "glossy") {
        EXPECT_EQ(out.decided_by, by) << out.why;
      }
    EXPECT_TRUE(leaves_out(p, "glossy"));
    EXPECT_TRUE(p.shading().visibility == "traced" || !has_pass(p, "octree")) << "nothing else wants one here";
  };
  for (const char* mode : {"uniform", "bandwidth"}) {
    const FramePlan p = plan(facts, mode, settings, view);
    EXPECT_TRUE(p.glossy && has_pass(p, "glossy") && has_pass(p, "octree"));
    EXPECT_FALSE(leaves_out(p, "glossy"));
  }
  expect_left_out("splitsum", "mode");
  expect_left_out("reference", "mode");
  view.glossy_in_view = 0;
  expect_left_out("uniform", "view");
  view.glossy_in_view = -1;
  facts.least_roughness = 0.45f;
  expect_left_out("uniform", "view");
  settings.set("reflections.glossy", 0.0);
  expect_left_out("uniform", "reflections.glossy");
  view.glossy_in_view = 1;
  EXPECT_TRUE(plan(facts, "uniform", settings, view).glossy) << "a named part";
  settings.set("reflections.glossy", 0.3);
  settings.set("shading.indirect", std::string("none"));
  expect_left_out("uniform", "shading.indirect");
  settings.set("shading.indirect", std::string("baked"));
  settings.set("shading.visibility", std::string("none"));
  expect_left_out("uniform", "shading.visibility");
  settings.set("shading.visibility", std::string("traced"));
  EXPECT_TRUE(plan(facts, "uniform", settings, view).glossy);
  view.reflections = "raytraced";
  const FramePlan exact = plan(facts, "uniform", settings, view);
  EXPECT_TRUE(exact.glossy && has_pass(exact, "glossy"));
  for (const char* technique : {"off", "bezier", "triangle"}) {
    view.reflections = technique;
    expect_left_out("uniform", "--reflections");
  }
}

TEST(Facts, KnowTheSmoothestOpaqueSurface) {
  Scene scene = make_box(true);
  scene.materials[0].roughness = 0.6f;
  scene.materials[1].roughness = 0.4f;
  const auto least = [&] { return compute_facts(scene, -1).least_roughness; };
  EXPECT_FLOAT_EQ(least(), 0.4f);
  scene.materials[0].clearcoat = 1.0f;
  scene.materials[0].clearcoat_roughness = 0.05f;
  EXPECT_FLOAT_EQ(least(), 0.05f);
  scene.materials[0].glass = true;
  EXPECT_FLOAT_EQ(least(), 0.4f);
  scene.materials[1].measured = "builtin:leather-black";
  EXPECT_FLOAT_EQ(least(), 0.0f);
}

/// A scene from elsewhere marks no reflectors: its panes are. Marks and names choose others; plan and renderer agree.
TEST(Plan, PanesReflectWhereNothingIsMarked) {
  Scene scene;
  Material glass, chrome;
  glass.glass = true;
  chrome.metallic = 1.0f;
  chrome.roughness = 0.0f;
  scene.materials = {glass, chrome};
  test::add(&scene, test::make_grid({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 2, 0));
  test::add(&scene, test::make_grid({-1, -1, -1}, {2, 0, 0}, {0, 2, 0}, 2, 1));
  scene.nodes[0].name = "pane";
  const auto reflecting = [&](const std::vector<std::string>& names) {
    const FlatGeometry geometry = flatten(scene);
    std::vector<const Material*> of_items(geometry.items.size());
    for (std::size_t i = 0; i < of_items.size(); ++i)
      of_items[i] = &scene.materials[geometry.items[i].node == 0 ? 0 : 1];
    std::vector<int> nodes;
    for (const Reflector& r : find_reflectors(scene, geometry, of_items, names)) nodes.push_back(r.node);
    return nodes;
  };
  EXPECT_EQ(reflecting({}), std::vector<int>{0});
  EXPECT_EQ(compute_facts(scene, -1).reflector_count, 1);
  scene.nodes[1].reflector = true;
  EXPECT_EQ(reflecting({}), std::vector<int>{1});
  EXPECT_EQ(compute_facts(scene, -1).reflector_count, 1);
  EXPECT_EQ(reflecting({"pane"}), std::vector<int>{0});
  scene.nodes[1].reflector = false;
  scene.materials[0].glass = false;
  EXPECT_TRUE(reflecting({}).empty());
  EXPECT_EQ(compute_facts(scene, -1).reflector_count, 0);
}

TEST(Plan, NeverFallsBack) {
  Settings baked;
  baked.set("shading.visibility", std::string("baked"));
  EXPECT_THROW(plan({}, "splitsum", baked, {}), Error);
  EXPECT_THROW(plan({}, "slf", baked, {}), Error);
  EXPECT_THROW(plan({}, "prt", baked, {}), Error);
  EXPECT_THROW(plan({}, "nonsense", {}, {}), UsageError);
  EXPECT_THROW(plan({}, "uniform", {}, {.msaa = 3}), UsageError);
  EXPECT_THROW(plan({}, "uniform", {}, {.width = 0}), UsageError);
}

TEST(Plan, IndirectLightGoesWithShadowsOfTheSky) {
  SceneFacts facts;
  Settings settings;
  EXPECT_EQ(plan(facts, "uniform", settings, {}).shading().indirect, "none");
  EXPECT_TRUE(leaves_out(plan(facts, "uniform", settings, {}), "indirect")) << "nothing occludes";
  facts.enclosed = true;
  for (const char* mode : {"uniform", "bandwidth"}) {
    EXPECT_EQ(plan(facts, mode, settings, {}).shading().indirect, "baked");
    EXPECT_TRUE(has_pass(plan(facts, mode, settings, {}), "indirect"));
    EXPECT_FALSE(leaves_out(plan(facts, mode, settings, {}), "indirect"));
  }
  EXPECT_TRUE(leaves_out(plan(facts, "splitsum", settings, {}), "indirect"));
  EXPECT_FALSE(leaves_out(plan(facts, "reference", settings, {}), "indirect")) << "it traces all light";
  settings.set("shading.indirect", std::string("none"));
  EXPECT_EQ(plan(facts, "uniform", settings, {}).shading().indirect, "none");
  settings.set("shading.indirect", std::string("baked"));
  settings.set("shading.visibility", std::string("none"));
  EXPECT_TRUE(leaves_out(plan(facts, "uniform", settings, {}), "indirect"));
}

/// Else a cabin would be black from the moment when shadows are there until indirect light is.
TEST(Plan, TheSkysShadowsComeWithIndirectLight) {
  SceneFacts facts;
  facts.enclosed = true;
  FrameStatus status;
  status.accumulated = 1;
  status.indirect.ready = false;
  Settings settings;
  for (const char* mode : {"uniform", "bandwidth"}) {
    const FramePlan before = plan(facts, mode, settings, {}, status);
    EXPECT_EQ(before.shading().visibility, "none");
    EXPECT_TRUE(leaves_out(before, "visibility"));
    EXPECT_TRUE(before.shading().shadow_rays) << "the sun's are there";
    EXPECT_FALSE(before.shading().sky_rays);
    EXPECT_TRUE(before.prepares("bake_visibility"));
    EXPECT_TRUE(before.prepares("bake_indirect"));
  }
  status.indirect.ready = true;
  EXPECT_EQ(plan(facts, "bandwidth", settings, {}, status).shading().visibility, "baked");
  EXPECT_TRUE(plan(facts, "bandwidth", settings, {}, status).shading().sky_rays);
  status.indirect.ready = false;
  EXPECT_EQ(plan(facts, "splitsum", settings, {}, status).shading().visibility,
            plan(facts, "splitsum", settings, {}).shading().visibility)
      << "a mode without indirect light waits for nothing";
  settings.set("shading.indirect", std::string("none"));
  EXPECT_EQ(plan(facts, "bandwidth", settings, {}, status).shading().visibility, "baked");
  EXPECT_TRUE(plan(facts, "bandwidth", settings, {}, status).shading().sky_rays);
}

TEST(Plan, ASceneThatNeedsLittlePaysLittle) {
  const FramePlan small = plan({}, "bandwidth", {}, {});
  for (const char* what :
       {"texture_bandwidth", "glass", "lights", "multisampling", "reflections", "octree", "visibility"})
    EXPECT_TRUE(leaves_out(small, what)) << what;
  SceneFacts rich;
  rich.has_textures = rich.has_glass = rich.has_punctual_lights = rich.enclosed = true;
  const FramePlan large = plan(rich, "bandwidth", {}, {.msaa = 4});
  for (const char* what : {"texture_bandwidth", "glass", "lights", "multisampling", "visibility"})
    EXPECT_FALSE(leaves_out(large, what)) << what;
  EXPECT_TRUE(large.shading().texture_bandwidth && large.glass && large.shading().lights);
  EXPECT_TRUE(has_pass(large, "multisampling"));
  Settings finest;
  finest.set("bandwidth.max_level", 0);
  EXPECT_FALSE(has_pass(plan(rich, "bandwidth", finest, {}), "upsample"));
}

TEST(Plan, PrefilteredModesSayThatTheyLeaveLightsOut) {
  SceneFacts facts;
  facts.has_punctual_lights = facts.has_emissive_meshes = true;
  for (const char* mode : {"splitsum", "sg"}) {
    const FramePlan made = plan(facts, mode, {}, {});
    EXPECT_FALSE(made.shading().lights) << mode;
    EXPECT_TRUE(std::any_of(made.left_out.begin(), made.left_out.end(), [](const LeftOut& out) {
      return out.what == "lights";
    })) << mode;
  }
}

/// The words in backquotes at the start of the table rows of docs/vocabulary.md.
std::set<std::string> documented_words() {
  std::ifstream stream(MAQUETTE_SOURCE_DIR "/docs/vocabulary.md");
  std::set<std::string> words;
  for (std::string line; std::getline(stream, line);) {
    if (!line.starts_with("| `")) continue;
    const std::string cell = line.substr(2, line.find(" |", 2) - 2);
    for (std::size_t begin = cell.find('`'); begin != std::string::npos;) {
      const std::size_t end = cell.find('`', begin + 1);
      words.insert(cell.substr(begin + 1, end - begin - 1));
      begin = cell.find('`', end + 1);
    }
  }
  return words;
}

TEST(Plan, EverythingHasAReasonAndNothingIsBothInAndOut) {
  SceneFacts rich;
  rich.has_textures = rich.has_normal_maps = rich.has_mask = rich.has_glass = rich.has_punctual_lights = true;
  rich.has_emissive_meshes = rich.has_subdivision = rich.enclosed = true;
  const std::set<std::string> documented = documented_words();
  for (const std::string& mode : builtin_registry().names(TechniqueKind::mode)) {
    for (const SceneFacts& facts : {SceneFacts{}, rich}) {
      for (const int msaa : {1, 4}) {
        const FramePlan made = plan(facts, mode, {}, {.msaa = msaa});
        std::set<std::string> seen;
        for (const std::vector<PlannedPass>& passes : {made.preparations, made.passes}) {
          for (const PlannedPass& pass : passes) {
            EXPECT_FALSE(pass.reason.empty());
            EXPECT_TRUE(seen.insert(pass.name).second) << mode << ": " << pass.name << " twice";
          }
        }
        for (const Feature& feature : made.features) {
          EXPECT_FALSE(feature.reason.empty());
          EXPECT_TRUE(seen.insert(feature.name).second) << mode << ": " << feature.name << " twice";
        }
        for (const LeftOut& left_out : made.left_out) {
          EXPECT_FALSE(left_out.why.empty());
          EXPECT_TRUE(seen.insert(left_out.what).second) << mode << ": " << left_out.what << " twice";
        }
        for (const std::string& word : seen)
          EXPECT_TRUE(documented.contains(word)) << word << " is not in docs/vocabulary.md";
        EXPECT_EQ(made.passes.front().name, mode == "reference" ? "trace" : "raster");
      }
    }
  }
}

}  // namespace
}  // namespace maquette
