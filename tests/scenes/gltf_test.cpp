#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <set>

#include "gltf_fixture.h"

namespace maquette {
namespace {

class Gltf : public test::GltfFixture {
 protected:
  /// A PNG of one texel.
  static constexpr const char* kPng =
      "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8/5+hHgAHggJ/"
      "PchI7wAAAABJRU5ErkJggg==";

  const Primitive& loaded_primitive() {
    scene_ = load();
    return scene_.meshes.at(0).primitives.at(0);
  }
  void use_material(const test::Json& material) {
    root_["materials"].push_back(material);
    primitive()["material"] = 0;
  }
  Scene scene_;
};

TEST_F(Gltf, ReadsIndexedTriangles) {
  add_quad();
  const Primitive& out = loaded_primitive();
  EXPECT_EQ(out.positions[2], glm::vec3(1, 1, 0));
  EXPECT_EQ(out.indices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(out.material, -1);
  EXPECT_TRUE(scene_.warnings.empty());
  EXPECT_EQ(count_triangles(scene_), 2u);
}

TEST_F(Gltf, NumbersVerticesWithoutIndices) {
  primitive()["attributes"]["POSITION"] = add_accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0}, 5126, "VEC3", 3);
  EXPECT_EQ(loaded_primitive().indices, (std::vector<std::uint32_t>{0, 1, 2}));
}

TEST_F(Gltf, TurnsStripsAndFansIntoTriangles) {
  add_quad();
  primitive()["mode"] = 5;
  primitive()["indices"] = add_accessor<std::uint8_t>({0, 1, 3, 2}, 5121, "SCALAR", 1);
  EXPECT_EQ(loaded_primitive().indices, (std::vector<std::uint32_t>{0, 1, 3, 1, 2, 3}));
  primitive()["mode"] = 6;
  primitive()["indices"] = add_accessor<std::uint32_t>({0, 1, 2, 3}, 5125, "SCALAR", 1);
  EXPECT_EQ(loaded_primitive().indices, (std::vector<std::uint32_t>{1, 2, 0, 2, 3, 0}));
}

TEST_F(Gltf, WarnsOnceOfPointsAndLines) {
  add_quad();
  test::Json points = primitive(), lines = primitive();
  points["mode"] = 0;
  lines["mode"] = 3;
  root_["meshes"][0]["primitives"].push_back(points);
  root_["meshes"][0]["primitives"].push_back(lines);
  const Scene scene = load();
  EXPECT_EQ(scene.meshes[0].primitives.size(), 1u);
  expect_warning(scene, "meshes[0].primitives[1] and 1 more: points and lines are not drawn");
}

TEST_F(Gltf, ReadsAllComponentTypes) {
  add_quad();
  auto& attributes = primitive()["attributes"];
  attributes["NORMAL"] = add_accessor<std::int8_t>({0, 0, 127, 0, 0, 0, -128, 0, 0, 127, 0, 0}, 5120, "VEC3", 3, true);
  attributes["TANGENT"] = add_accessor<std::int16_t>(
      {32767, 0, 0, -32767, 32767, 0, 0, 32767, 32767, 0, 0, 32767, 32767, 0, 0, 32767}, 5122, "VEC4", 4, true);
  attributes["TEXCOORD_0"] = add_accessor<std::uint8_t>({0, 51, 255, 102, 0, 0, 0, 0}, 5121, "VEC2", 2, true);
  attributes["TEXCOORD_1"] = add_accessor<std::uint16_t>({0, 65535, 13107, 0, 0, 0, 0, 0}, 5123, "VEC2", 2, true);
  attributes["COLOR_0"] = add_accessor<std::uint8_t>({255, 0, 51, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 5121, "VEC3", 3, true);
  const Primitive& out = loaded_primitive();
  EXPECT_EQ(out.normals[0], glm::vec3(0, 0, 1));
  EXPECT_EQ(out.normals[2], glm::vec3(-1, 0, 0));  // -128 is -1 too
  EXPECT_EQ(out.tangents[0], glm::vec4(1, 0, 0, -1));
  EXPECT_FLOAT_EQ(out.uvs[0][0].y, 0.2f);
  EXPECT_FLOAT_EQ(out.uvs[0][1].y, 0.4f);
  EXPECT_FLOAT_EQ(out.uvs[1][1].x, 0.2f);
  EXPECT_FLOAT_EQ(out.colors[0].b, 0.2f);
  EXPECT_FLOAT_EQ(out.colors[0].a, 1.0f);
  EXPECT_TRUE(scene_.warnings.empty());
}

/// KHR_mesh_quantization: unchanged integer positions, padded to four bytes, scaled by the node.
TEST_F(Gltf, ReadsQuantizedMeshes) {
  add_quad();
  root_["extensionsUsed"] = root_["extensionsRequired"] = {"KHR_mesh_quantization"};
  root_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", 0}, {"byteLength", 0}});
  const int view = add_view<std::int16_t>({-100, 0, 0, 99, 100, 0, 0, 99, 0, 50, 0, 99, 0, 0, 0, 99}, 8);
  root_["accessors"].push_back({{"bufferView", view}, {"componentType", 5122}, {"count", 4}, {"type", "VEC3"}});
  primitive()["attributes"]["POSITION"] = static_cast<int>(root_["accessors"].size()) - 1;
  root_["nodes"][0]["scale"] = {0.01, 0.01, 0.01};
  EXPECT_EQ(loaded_primitive().positions[1], glm::vec3(100, 0, 0));
  EXPECT_NEAR(compute_bounds(scene_).min.x, -1.0f, 1e-6f);
  EXPECT_TRUE(scene_.warnings.empty());
}

TEST_F(Gltf, PutsSparseValuesInPlace) {
  add_quad();
  const int places = add_view<std::uint16_t>({1, 3});
  const int values = add_view<float>({9, 8, 7, 6, 5, 4});
  root_["accessors"][0]["sparse"] = {{"count", 2},
                                     {"indices", {{"bufferView", places}, {"componentType", 5123}}},
                                     {"values", {{"bufferView", values}}}};
  const Primitive& dense = loaded_primitive();
  EXPECT_EQ(dense.positions[0], glm::vec3(0, 0, 0));
  EXPECT_EQ(dense.positions[1], glm::vec3(9, 8, 7));
  EXPECT_EQ(dense.positions[2], glm::vec3(1, 1, 0));
  EXPECT_EQ(dense.positions[3], glm::vec3(6, 5, 4));
  root_["accessors"][0].erase("bufferView");  // then the rest is zero
  EXPECT_EQ(loaded_primitive().positions[2], glm::vec3(0, 0, 0));
  EXPECT_EQ(loaded_primitive().positions[3], glm::vec3(6, 5, 4));
}

TEST_F(Gltf, BuildsTheNodeTree) {
  add_quad();
  root_["nodes"] = test::Json::parse(R"([
    {"name": "unused", "mesh": 0},
    {"name": "car", "translation": [1, 2, 3], "children": [2]},
    {"name": "door", "rotation": [0, 1.4142135, 0, 1.4142135], "scale": [2, 1, 1], "mesh": 0, "children": [3]},
    {"name": "handle", "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 1,0,0,1]}])");
  root_["scenes"] = test::Json::parse(R"([{"nodes": [0]}, {"nodes": [1]}])");
  root_["scene"] = 1;
  const Scene scene = load();
  ASSERT_EQ(scene.nodes.size(), 3u);
  EXPECT_EQ(scene.roots, std::vector<int>{0});
  EXPECT_EQ(scene.nodes[1].parent, 0);
  EXPECT_EQ(scene.nodes[1].children, std::vector<int>{2});
  const auto world = compute_world_transforms(scene);
  // Handle: (1,0,0), scaled by 2 along x, rotated by 90 degrees about +y (x to -z), translated.
  EXPECT_LT(glm::distance(glm::vec3(world[2][3]), glm::vec3(1, 2, 1)), 1e-6f);
  expect_warning(scene, "only the default of 2 scenes");
}

TEST_F(Gltf, ReadsCamerasAndLights) {
  add_quad();
  root_["cameras"] = test::Json::parse(R"([
    {"type": "perspective", "perspective": {"yfov": 0.5, "aspectRatio": 1.5, "znear": 0.1, "zfar": 20}},
    {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0.1, "zfar": 20}},
    {"type": "perspective", "name": "passenger", "perspective": {"yfov": 0.7, "znear": 0.2}}])");
  root_["nodes"] = test::Json::parse(R"([{"mesh": 0}, {"name": "driver", "camera": 0}, {"camera": 1}, {"camera": 2},
    {"extensions": {"KHR_lights_punctual": {"light": 1}}}])");
  root_["scenes"][0]["nodes"] = {0, 1, 2, 3, 4};
  root_["extensionsUsed"] = {"KHR_lights_punctual"};
  root_["extensions"]["KHR_lights_punctual"]["lights"] = test::Json::parse(R"([
    {"type": "directional", "intensity": 1000, "color": [1, 0.5, 0]},
    {"type": "spot", "intensity": 7, "range": 2, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.3}}])");
  const Scene scene = load();
  ASSERT_EQ(scene.cameras.size(), 3u);
  EXPECT_EQ(scene.cameras[0].name, "driver");
  EXPECT_FLOAT_EQ(scene.cameras[0].fov_y_rad, 0.5f);
  EXPECT_FLOAT_EQ(scene.cameras[0].aspect, 1.5f);
  EXPECT_EQ(scene.cameras[2].aspect, 0.0f);
  EXPECT_FLOAT_EQ(scene.cameras[1].height_m, 2.0f);
  EXPECT_FLOAT_EQ(scene.cameras[0].far_m, 20.0f);
  EXPECT_EQ(scene.nodes[2].camera, 1);
  EXPECT_EQ(scene.nodes[3].camera, 2);
  EXPECT_EQ(scene.cameras[2].name, "passenger");
  ASSERT_EQ(scene.lights.size(), 2u);
  EXPECT_EQ(scene.lights[0].kind, PunctualLight::Kind::directional);
  EXPECT_EQ(scene.lights[0].color, glm::vec3(1, 0.5f, 0));
  EXPECT_EQ(scene.lights[1].kind, PunctualLight::Kind::spot);
  EXPECT_FLOAT_EQ(scene.lights[1].outer_cone_rad, 0.3f);
  EXPECT_EQ(scene.nodes[4].light, 1);
}

TEST_F(Gltf, ReadsMaterialsAndTheirExtensions) {
  add_quad();
  use_material(test::Json::parse(R"({"name": "paint", "doubleSided": true, "alphaMode": "MASK", "alphaCutoff": 0.25,
    "emissiveFactor": [0.5, 0.25, 1], "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 0.4],
    "metallicFactor": 0.6, "roughnessFactor": 0.7}, "extensions": {
      "KHR_materials_clearcoat": {"clearcoatFactor": 0.9, "clearcoatRoughnessFactor": 0.1},
      "KHR_materials_transmission": {"transmissionFactor": 0.8}, "KHR_materials_ior": {"ior": 1.7},
      "KHR_materials_volume": {"thicknessFactor": 0.02, "attenuationDistance": 0.5, "attenuationColor": [0.2, 0.9, 0.4]},
      "KHR_materials_specular": {"specularFactor": 0.3, "specularColorFactor": [1, 2, 3]},
      "KHR_materials_sheen": {"sheenColorFactor": [0.1, 0.2, 0.3], "sheenRoughnessFactor": 0.4},
      "KHR_materials_emissive_strength": {"emissiveStrength": 100}, "KHR_materials_unlit": {}},
    "extras": {"maquette": {"measured": "tables/gold.binary", "tint_measured": true}}})"));
  const Scene scene = load();
  const Material& m = scene.materials.at(0);
  EXPECT_EQ(m.name, "paint");
  EXPECT_EQ(m.base_color, glm::vec4(0.1f, 0.2f, 0.3f, 0.4f));
  EXPECT_FLOAT_EQ(m.metallic, 0.6f);
  EXPECT_FLOAT_EQ(m.roughness, 0.7f);
  EXPECT_EQ(m.emissive, glm::vec3(50, 25, 100));
  EXPECT_EQ(m.alpha_mode, AlphaMode::mask);
  EXPECT_FLOAT_EQ(m.alpha_cutoff, 0.25f);
  EXPECT_TRUE(m.double_sided);
  EXPECT_TRUE(m.unlit);
  EXPECT_FLOAT_EQ(m.clearcoat, 0.9f);
  EXPECT_FLOAT_EQ(m.clearcoat_roughness, 0.1f);
  EXPECT_FLOAT_EQ(m.transmission, 0.8f);
  EXPECT_TRUE(m.glass);
  EXPECT_FLOAT_EQ(m.ior, 1.7f);
  EXPECT_FLOAT_EQ(m.thickness, 0.02f);
  EXPECT_FLOAT_EQ(m.attenuation_distance, 0.5f);
  EXPECT_EQ(m.attenuation_color, glm::vec3(0.2f, 0.9f, 0.4f));
  EXPECT_FLOAT_EQ(m.specular, 0.3f);
  EXPECT_EQ(m.specular_color, glm::vec3(1, 2, 3));
  EXPECT_EQ(m.sheen_color, glm::vec3(0.1f, 0.2f, 0.3f));
  EXPECT_FLOAT_EQ(m.sheen_roughness, 0.4f);
  EXPECT_EQ(m.measured, path("tables/gold.binary"));
  EXPECT_TRUE(m.tint_measured);
  EXPECT_EQ(scene.meshes[0].primitives[0].material, 0);
  EXPECT_TRUE(scene.warnings.empty());
}

TEST_F(Gltf, ReadsTexturesSamplersAndTransforms) {
  add_quad();
  root_["images"] = {{{"uri", kPng}, {"name", "texel"}}};
  root_["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}}};
  root_["textures"] = {{{"source", 0}}, {{"source", 0}, {"sampler", 0}}};
  use_material(test::Json::parse(R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
    "normalTexture": {"index": 1, "scale": 0.5, "texCoord": 1}, "occlusionTexture": {"index": 0, "strength": 0.3},
    "emissiveTexture": {"index": 0, "extensions": {"KHR_texture_transform":
      {"offset": [0.1, 0.2], "rotation": 0.5, "scale": [3, 4], "texCoord": 1}}},
    "extensions": {"KHR_materials_clearcoat": {"clearcoatNormalTexture": {"index": 1}}}})"));
  const Scene scene = load();
  const Material& m = scene.materials.at(0);
  EXPECT_EQ(m.base_color_texture.image, 0);
  EXPECT_EQ(m.base_color_texture.wrap_s, Wrap::repeat);
  EXPECT_FALSE(m.base_color_texture.nearest);
  EXPECT_EQ(m.normal_texture.wrap_s, Wrap::clamp_to_edge);
  EXPECT_EQ(m.normal_texture.wrap_t, Wrap::mirrored_repeat);
  EXPECT_TRUE(m.normal_texture.nearest);
  EXPECT_EQ(m.normal_texture.uv_set, 1);
  EXPECT_FLOAT_EQ(m.normal_scale, 0.5f);
  EXPECT_FLOAT_EQ(m.occlusion_strength, 0.3f);
  EXPECT_EQ(m.emissive_texture.uv_set, 1);
  EXPECT_EQ(m.emissive_texture.offset, glm::vec2(0.1f, 0.2f));
  EXPECT_EQ(m.emissive_texture.scale, glm::vec2(3, 4));
  EXPECT_FLOAT_EQ(m.emissive_texture.rotation_rad, 0.5f);
  EXPECT_TRUE(m.clearcoat_normal_texture);
  EXPECT_FALSE(m.sheen_color_texture);
  ASSERT_EQ(scene.images.size(), 1u);
  EXPECT_EQ(scene.images[0].rgba, (std::vector<std::uint8_t>{255, 255, 0, 127}));
}

TEST_F(Gltf, ReadsVariants) {
  add_quad();
  root_["materials"] = {{{"name", "red"}}, {{"name", "blue"}}};
  root_["extensionsUsed"] = {"KHR_materials_variants"};
  root_["extensions"]["KHR_materials_variants"]["variants"] =
      test::Json::parse(R"([{"name": "A"}, {"name": "B"}, {"name": "C"}])");
  primitive()["material"] = 0;
  primitive()["extensions"]["KHR_materials_variants"]["mappings"] =
      test::Json::parse(R"([{"material": 1, "variants": [1, 2]}])");
  const Primitive& out = loaded_primitive();
  EXPECT_EQ(scene_.variants, (std::vector<std::string>{"A", "B", "C"}));
  EXPECT_EQ(material_of(out, -1), 0);
  EXPECT_EQ(material_of(out, 0), 0);
  EXPECT_EQ(material_of(out, 1), 1);
  EXPECT_EQ(material_of(out, 2), 1);
}

TEST_F(Gltf, ReadsExternalAndEmbeddedBuffers) {
  add_quad();
  test::Json root = root_;
  root["buffers"] = {{{"byteLength", bytes_.size()}, {"uri", "my%20data.bin"}}};
  std::vector<char> longer = bytes_;
  longer.push_back('x');  // files may be longer than the buffer
  write("my data.bin", longer);
  const std::string text = root.dump();
  EXPECT_EQ(count_triangles(load_gltf(write("a.gltf", {text.begin(), text.end()}))), 2u);
  root["buffers"][0]["uri"] =
      "data:application/"
      "octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwAAgD8AAAAAAAAAAAAAgD8AAAAAAAABAAIAAAACAAMA";
  const std::string embedded = root.dump();
  EXPECT_EQ(count_triangles(load_gltf(write("b.gltf", {embedded.begin(), embedded.end()}))), 2u);
}

TEST_F(Gltf, NamesEverythingThatIsNotSupportedOnce) {
  add_quad();
  primitive()["attributes"]["_TEMPERATURE"] = 0;
  root_["extensionsUsed"] = {"KHR_materials_dispersion", "ACME_wheels"};
  use_material({{"extensions",
                 {{"KHR_materials_dispersion", test::Json::object()},
                  {"KHR_materials_diffuse_transmission", test::Json::object()}}},
                {"extras", {{"extensions", {{"not_an_extension", 1}}}}}});
  const Scene scene = load();
  expect_warning(scene, "_TEMPERATURE");
  expect_warning(scene, "KHR_materials_dispersion");
  expect_warning(scene, "KHR_materials_diffuse_transmission");
  expect_warning(scene, "ACME_wheels");
  EXPECT_EQ(scene.warnings.size(), 4u);
  EXPECT_EQ(count_triangles(scene), 2u);
  root_["extensionsRequired"] = {"ACME_wheels"};
  expect_error("requires the extension ACME_wheels");
}

}  // namespace
}  // namespace maquette
