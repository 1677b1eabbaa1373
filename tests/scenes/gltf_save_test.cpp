#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "gltf_fixture.h"
#include "scenes/subdivision.h"

namespace maquette {
namespace {

class GltfSave : public test::GltfFixture {};

void expect_equal(const TextureRef& a, const TextureRef& b) {
  EXPECT_EQ(a.image, b.image);
  EXPECT_EQ(a.uv_set, b.uv_set);
  EXPECT_EQ(a.offset, b.offset);
  EXPECT_EQ(a.scale, b.scale);
  EXPECT_EQ(a.rotation_rad, b.rotation_rad);
  EXPECT_EQ(a.wrap_s, b.wrap_s);
  EXPECT_EQ(a.wrap_t, b.wrap_t);
  EXPECT_EQ(a.nearest, b.nearest);
}

void expect_equal(const Material& a, const Material& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.base_color, b.base_color);
  EXPECT_EQ(a.metallic, b.metallic);
  EXPECT_EQ(a.roughness, b.roughness);
  EXPECT_EQ(a.emissive, b.emissive);
  EXPECT_EQ(a.normal_scale, b.normal_scale);
  EXPECT_EQ(a.occlusion_strength, b.occlusion_strength);
  EXPECT_EQ(a.alpha_mode, b.alpha_mode);
  EXPECT_EQ(a.alpha_cutoff, b.alpha_cutoff);
  EXPECT_EQ(a.double_sided, b.double_sided);
  EXPECT_EQ(a.unlit, b.unlit);
  EXPECT_EQ(a.clearcoat, b.clearcoat);
  EXPECT_EQ(a.clearcoat_roughness, b.clearcoat_roughness);
  EXPECT_EQ(a.transmission, b.transmission);
  EXPECT_EQ(a.ior, b.ior);
  EXPECT_EQ(a.thickness, b.thickness);
  EXPECT_EQ(a.attenuation_color, b.attenuation_color);
  EXPECT_EQ(a.attenuation_distance, b.attenuation_distance);
  EXPECT_EQ(a.specular, b.specular);
  EXPECT_EQ(a.specular_color, b.specular_color);
  EXPECT_EQ(a.sheen_color, b.sheen_color);
  EXPECT_EQ(a.sheen_roughness, b.sheen_roughness);
  EXPECT_EQ(a.clearcoat_normal_scale, b.clearcoat_normal_scale);
  EXPECT_EQ(a.anisotropy, b.anisotropy);
  EXPECT_EQ(a.anisotropy_rotation_rad, b.anisotropy_rotation_rad);
  EXPECT_EQ(a.iridescence, b.iridescence);
  EXPECT_EQ(a.iridescence_ior, b.iridescence_ior);
  EXPECT_EQ(a.iridescence_least_nm, b.iridescence_least_nm);
  EXPECT_EQ(a.iridescence_greatest_nm, b.iridescence_greatest_nm);
  EXPECT_EQ(a.measured, b.measured);
  EXPECT_EQ(a.tint_measured, b.tint_measured);
  EXPECT_EQ(a.glass, b.glass);
  for (const auto texture : kMaterialTextures) expect_equal(a.*texture, b.*texture);
}

void expect_equal(const Mesh& a, const Mesh& b) {
  EXPECT_EQ(a.name, b.name);
  ASSERT_EQ(a.primitives.size(), b.primitives.size());
  for (std::size_t i = 0; i < a.primitives.size(); ++i) {
    const Primitive &p = a.primitives[i], &q = b.primitives[i];
    EXPECT_EQ(p.positions, q.positions);
    EXPECT_EQ(p.normals, q.normals);
    EXPECT_EQ(p.tangents, q.tangents);
    EXPECT_EQ(p.uvs, q.uvs);
    EXPECT_EQ(p.colors, q.colors);
    EXPECT_EQ(p.indices, q.indices);
    EXPECT_EQ(p.material, q.material);
    EXPECT_EQ(p.variant_materials, q.variant_materials);
  }
  ASSERT_EQ(a.cage == nullptr, b.cage == nullptr);
  if (!a.cage) return;
  EXPECT_EQ(a.cage->positions, b.cage->positions);
  EXPECT_EQ(a.cage->uvs, b.cage->uvs);
  EXPECT_EQ(a.cage->face_sizes, b.cage->face_sizes);
  EXPECT_EQ(a.cage->face_indices, b.cage->face_indices);
  EXPECT_EQ(a.cage->crease_edges, b.cage->crease_edges);
  EXPECT_EQ(a.cage->crease_sharpness, b.cage->crease_sharpness);
  EXPECT_EQ(a.cage->levels, b.cage->levels);
}

void expect_equal(const Node& a, const Node& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.parent, b.parent);
  EXPECT_EQ(a.children, b.children);
  EXPECT_EQ(a.local, b.local);
  EXPECT_EQ(a.mesh, b.mesh);
  EXPECT_EQ(a.patch, b.patch);
  EXPECT_EQ(a.camera, b.camera);
  EXPECT_EQ(a.light, b.light);
  EXPECT_EQ(a.reflector, b.reflector);
  EXPECT_EQ(a.visible, b.visible);
}

void expect_equal(const Scene& a, const Scene& b) {
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (std::size_t i = 0; i < a.nodes.size(); ++i) expect_equal(a.nodes[i], b.nodes[i]);
  EXPECT_EQ(a.roots, b.roots);
  ASSERT_EQ(a.meshes.size(), b.meshes.size());
  for (std::size_t i = 0; i < a.meshes.size(); ++i) expect_equal(a.meshes[i], b.meshes[i]);
  ASSERT_EQ(a.materials.size(), b.materials.size());
  for (std::size_t i = 0; i < a.materials.size(); ++i) expect_equal(a.materials[i], b.materials[i]);
  ASSERT_EQ(a.images.size(), b.images.size());
  for (std::size_t i = 0; i < a.images.size(); ++i) {
    EXPECT_EQ(a.images[i].name, b.images[i].name);
    EXPECT_EQ(a.images[i].width, b.images[i].width);
    EXPECT_EQ(a.images[i].rgba, b.images[i].rgba);
  }
  ASSERT_EQ(a.patches.size(), b.patches.size());
  for (std::size_t i = 0; i < a.patches.size(); ++i) {
    EXPECT_EQ(a.patches[i].name, b.patches[i].name);
    EXPECT_EQ(a.patches[i].points, b.patches[i].points);
    EXPECT_EQ(a.patches[i].material, b.patches[i].material);
    EXPECT_EQ(a.patches[i].reflector, b.patches[i].reflector);
  }
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (std::size_t i = 0; i < a.cameras.size(); ++i) {
    EXPECT_EQ(a.cameras[i].name, b.cameras[i].name);
    EXPECT_EQ(a.cameras[i].fov_y_rad, b.cameras[i].fov_y_rad);
    EXPECT_EQ(a.cameras[i].aspect, b.cameras[i].aspect);
    EXPECT_EQ(a.cameras[i].near_m, b.cameras[i].near_m);
    EXPECT_EQ(a.cameras[i].height_m, b.cameras[i].height_m);
    EXPECT_EQ(a.cameras[i].far_m, b.cameras[i].far_m);
  }
  ASSERT_EQ(a.lights.size(), b.lights.size());
  for (std::size_t i = 0; i < a.lights.size(); ++i) {
    EXPECT_EQ(a.lights[i].name, b.lights[i].name);
    EXPECT_EQ(a.lights[i].kind, b.lights[i].kind);
    EXPECT_EQ(a.lights[i].color, b.lights[i].color);
    EXPECT_EQ(a.lights[i].intensity, b.lights[i].intensity);
    EXPECT_EQ(a.lights[i].range_m, b.lights[i].range_m);
    EXPECT_EQ(a.lights[i].inner_cone_rad, b.lights[i].inner_cone_rad);
    EXPECT_EQ(a.lights[i].outer_cone_rad, b.lights[i].outer_cone_rad);
  }
  EXPECT_EQ(a.variants, b.variants);
}

/// A scene in which every member differs from its default.
Scene everything() {
  Scene scene;
  scene.variants = {"red", "blue"};
  TextureImage& image = scene.images.emplace_back();
  image.name = "checker";
  image.width = 2;
  image.height = 1;
  image.rgba = {255, 0, 0, 255, 1, 2, 3, 0};
  Material material;
  material.name = "all";
  material.base_color = {0.1f, 0.2f, 0.3f, 0.4f};
  material.metallic = 0.3f;
  material.roughness = 0.7f;
  material.emissive = {0.3f, 123.4f, 7.0f};
  material.normal_scale = 0.6f;
  material.occlusion_strength = 0.2f;
  material.alpha_mode = AlphaMode::mask;
  material.alpha_cutoff = 0.3f;
  material.double_sided = material.unlit = material.tint_measured = true;
  material.clearcoat = 0.9f;
  material.clearcoat_roughness = 0.05f;
  material.transmission = 0.8f;
  material.ior = 1.33f;
  material.thickness = 0.01f;
  material.attenuation_color = {0.5f, 0.6f, 0.7f};
  material.attenuation_distance = 0.25f;
  material.specular = 0.4f;
  material.specular_color = {0.9f, 0.8f, 0.7f};
  material.sheen_color = {0.1f, 0.0f, 0.2f};
  material.sheen_roughness = 0.35f;
  material.clearcoat_normal_scale = 0.7f;
  material.anisotropy = 0.6f;
  material.anisotropy_rotation_rad = 1.1f;
  material.iridescence = 0.4f;
  material.iridescence_ior = 1.7f;
  material.iridescence_least_nm = 50.0f;
  material.iridescence_greatest_nm = 350.0f;
  material.measured = "builtin:paint-solid-red";
  material.glass = false;
  float rotation = 0.0f;
  for (const auto texture : kMaterialTextures) {
    TextureRef& ref = material.*texture;
    ref.image = 0;
    ref.rotation_rad = rotation += 0.1f;
    ref.offset = {0.1f, 0.2f};
    ref.scale = {2.0f, 3.0f};
    ref.uv_set = 1;
    ref.wrap_s = Wrap::clamp_to_edge;
    ref.wrap_t = Wrap::mirrored_repeat;
    ref.nearest = true;
  }
  scene.materials = {material, Material{}};
  scene.materials[1].name = "plain";

  Primitive triangle;
  triangle.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  triangle.normals.assign(3, {0, 0, 1});
  triangle.tangents.assign(3, {1, 0, 0, -1});
  triangle.uvs[0] = {{0, 0}, {1, 0}, {0, 1}};
  triangle.uvs[1] = {{0, 0}, {0.5f, 0}, {0, 0.5f}};
  triangle.colors.assign(3, {0.5f, 0.25f, 1.0f, 0.75f});
  triangle.indices = {0, 1, 2};
  triangle.material = 0;
  triangle.variant_materials = {{0, 1}, {1, 0}};
  Mesh plain{"triangle", {triangle}, nullptr};
  SubdivisionCage cage;
  cage.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.5f}, {2, 0, 0}, {2, 1, 1}};
  cage.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {2, 0}, {2, 1}};
  cage.face_sizes = {4, 4};
  cage.face_indices = {0, 1, 2, 3, 1, 4, 5, 2};
  cage.crease_edges = {{1, 2}};
  cage.crease_sharpness = {1.5f};
  cage.levels = 3;
  Mesh smooth{"seat", {}, std::make_shared<const SubdivisionCage>(cage)};
  tessellate_cage(&smooth);
  smooth.primitives[0].material = 1;
  scene.meshes = {plain, smooth};

  BezierPatch patch;
  patch.name = "windshield";
  for (std::size_t i = 0; i < 16; ++i) patch.points[i] = glm::vec3(static_cast<float>(i) * 0.1f, 1.0f / 3.0f, -2.0f);
  patch.material = 1;
  patch.reflector = false;
  scene.patches = {patch};
  scene.cameras = {{"driver", 0.9f, 0.02f, 55.0f}};
  PunctualLight spot;
  spot.name = "map light";
  spot.kind = PunctualLight::Kind::spot;
  spot.color = {1.0f, 0.9f, 0.8f};
  spot.intensity = 12.5f;
  spot.range_m = 3.0f;
  spot.inner_cone_rad = 0.2f;
  spot.outer_cone_rad = 0.4f;
  scene.lights = {spot, PunctualLight{.name = "sun", .kind = PunctualLight::Kind::directional}};

  scene.nodes.resize(5);
  scene.nodes[0].name = "car";
  scene.nodes[0].children = {1, 2, 3};
  scene.nodes[0].local = glm::rotate(glm::translate(glm::mat4(1.0f), {1, 2, 3}), 0.3f, glm::vec3(0, 1, 0));
  scene.nodes[1].mesh = 0;
  scene.nodes[1].visible = false;
  scene.nodes[2].mesh = 1;
  scene.nodes[2].light = 0;
  scene.nodes[3].patch = 0;
  scene.nodes[3].reflector = true;
  for (std::size_t i = 1; i < 4; ++i) scene.nodes[i].parent = 0;
  scene.nodes[4].camera = 0;
  scene.nodes[4].light = 1;
  scene.roots = {0, 4};
  return scene;
}

TEST_F(GltfSave, LoadingGivesBackEverything) {
  const Scene scene = everything();
  save_glb(path("all.glb"), scene);
  const Scene loaded = load_gltf(path("all.glb"));
  expect_equal(scene, loaded);
  EXPECT_TRUE(loaded.warnings.empty()) << loaded.warnings.front();
  EXPECT_EQ(loaded.name, path("all.glb"));
}

TEST_F(GltfSave, KeepsAnEmptyScene) {
  save_glb(path("empty.glb"), Scene{});
  const Scene loaded = load_gltf(path("empty.glb"));
  EXPECT_TRUE(loaded.nodes.empty());
  expect_warning(loaded, "nothing to see");
}

TEST_F(GltfSave, NamesMeasuredTablesBesideTheFile) {
  Scene scene;
  scene.materials.resize(3);
  scene.materials[0].measured = path("paints/red.binary");
  scene.materials[1].measured = "/elsewhere/blue.binary";
  scene.materials[2].measured = "builtin:leather-black";
  for (Material& material : scene.materials) material.name = material.measured;
  std::filesystem::create_directories(path("moved"));
  save_glb(path("scene.glb"), scene);
  std::filesystem::rename(path("scene.glb"), path("moved/scene.glb"));
  const Scene loaded = load_gltf(path("moved/scene.glb"));
  EXPECT_EQ(loaded.materials[0].measured, path("moved/paints/red.binary"));
  EXPECT_EQ(loaded.materials[1].measured, "/elsewhere/blue.binary");
  EXPECT_EQ(loaded.materials[2].measured, "builtin:leather-black");
}

TEST_F(GltfSave, LeavesNothingHalfWritten) {
  EXPECT_THROW(save_glb(path("no/such/folder/scene.glb"), Scene{}), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

/// A cage whose stored surface is missing or outdated is evaluated again.
TEST_F(GltfSave, RebuildsASurfaceThatDoesNotFitItsCage) {
  Scene scene = everything();
  const Primitive expected = scene.meshes[1].primitives[0];
  scene.meshes[1].primitives[0].positions.resize(10);
  scene.meshes[1].primitives[0].normals.resize(10);
  scene.meshes[1].primitives[0].uvs[0].resize(10);
  scene.meshes[1].primitives[0].indices = {0, 1, 2};
  save_glb(path("stale.glb"), scene);
  const Scene loaded = load_gltf(path("stale.glb"));
  EXPECT_EQ(loaded.meshes[1].primitives[0].positions, expected.positions);
  EXPECT_EQ(loaded.meshes[1].primitives[0].indices, expected.indices);
  EXPECT_EQ(loaded.meshes[1].primitives[0].material, 1);
}

}  // namespace
}  // namespace maquette
