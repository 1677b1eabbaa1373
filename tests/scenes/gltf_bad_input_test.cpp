#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <limits>

#include "gltf_fixture.h"

namespace maquette {
namespace {

class GltfBadInput : public test::GltfFixture {
 protected:
  GltfBadInput() {
    add_quad();
    valid_root_ = root_;
  }
  /// Breaks one member of a valid file and expects an error that says so.
  void expect_fault(const std::string& pointer, const test::Json& value, const std::string& fault) {
    root_ = valid_root_;
    root_[test::Json::json_pointer(pointer)] = value;
    expect_error(fault);
  }
  test::Json valid_root_;
};

TEST_F(GltfBadInput, ADocumentOfTooManyNumbersIsRefusedUnread) {
  std::string text = "{\"asset\":{\"version\":\"2.0\"},\"extras\":[1";
  for (int i = 0; i < 20'000'001; ++i) text += ",1";
  text += "]}";
  expect_error(write("many.gltf", {text.begin(), text.end()}), "20 million values");
}

TEST_F(GltfBadInput, FilesThatAreNoScenes) {
  expect_error(path("missing.glb"), "missing.glb");
  expect_error(write("empty.glb", {}), "is not a glTF file");
  expect_error(write("noise.glb", std::vector<char>(100, '\x7f')), "is not valid JSON");
  const std::string number = "123456";
  expect_error(write("number.gltf", {number.begin(), number.end()}), "not an object");
  std::string deep =
      R"({"asset":{"version":"2.0"},"extras":)" + std::string(100000, '[') + std::string(100000, ']') + "}";
  expect_error(write("deep.gltf", {deep.begin(), deep.end()}), "nested deeper");
}

TEST_F(GltfBadInput, TruncatedGlb) {
  const std::vector<char> whole = glb();
  for (std::size_t size = 0; size < whole.size(); size += size < 32 ? 1 : 37) {
    const std::vector<char> part(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    expect_error(write("cut.glb", part), "cut.glb: ");
  }
  std::vector<char> old = whole;
  old[4] = 1;
  expect_error(write("old.glb", old), "GLB version 1");
  std::vector<char> longer = whole;
  longer.resize(whole.size() + 16);
  expect_warning(load_gltf(write("longer.glb", longer)), "after the end");
}

TEST_F(GltfBadInput, Versions) {
  expect_fault("/asset/version", "1.0", "is glTF 1.0");
  expect_fault("/asset/minVersion", "2.1", "is glTF 2.1");
  expect_fault("/asset", 3, "asset");
}

TEST_F(GltfBadInput, IndicesOutOfRange) {
  expect_fault("/nodes/0/mesh", 7, "nodes[0].mesh: 7 is out of range (the file has 1 meshes)");
  expect_fault("/nodes/0/mesh", -1, "nodes[0].mesh: -1 is out of range");
  expect_fault("/nodes/0/mesh", 0.5, "nodes[0].mesh: 0.5");
  expect_fault("/scenes/0/nodes/0", 4, "scenes[0].nodes[0]: 4");
  expect_fault("/scene", 4, "scene: 4");
  expect_fault("/meshes/0/primitives/0/indices", 99, "meshes[0].primitives[0].indices: 99");
  expect_fault("/meshes/0/primitives/0/attributes/POSITION", 99, "meshes[0].primitives[0].attributes.POSITION: 99");
  expect_fault("/meshes/0/primitives/0/material", 0, "material: 0 is out of range (the file has 0 materials)");
  expect_fault("/accessors/0/bufferView", 20, "accessors[0].bufferView: 20");
  expect_fault("/bufferViews/1/buffer", 3, "bufferViews[1].buffer: 3");
}

TEST_F(GltfBadInput, BadAccessors) {
  expect_fault("/accessors/0/componentType", 5127, "accessors[0]: componentType 5127");
  expect_fault("/accessors/0/type", "VEC2", "accessors[0]: has 2 components an element, 3 are needed");
  expect_fault("/accessors/0/type", "VEC9", "VEC9");
  expect_fault("/accessors/0/count", 5,
               "accessors[0]: 5 elements from byte 0 do not fit in bufferViews[0] of 48 bytes");
  expect_fault("/accessors/0/byteOffset", 4, "accessors[0]: 4 elements from byte 4 do not fit");
  expect_fault("/accessors/0/byteOffset", 9007199254740992, "do not fit");
  expect_fault("/accessors/0/count", 4611686018427387904, "accessors[0].count");
  expect_fault("/accessors/0/count", -1, "accessors[0].count: expected a whole number, found -1");
  expect_fault("/accessors/0/count", "many", "accessors[0].count");
  expect_fault("/accessors/1/componentType", 5126, "accessors[1]");
  expect_fault("/accessors/1/componentType", 5122, "cannot hold indices");
  expect_fault("/bufferViews/0/byteStride", 8, "overlap");
  expect_fault("/bufferViews/0/byteStride", 9007199254740992, "bufferViews[0].byteStride: 9007199254740992 is not");
  expect_fault("/bufferViews/0/byteStride", 14, "bufferViews[0].byteStride: 14 is not a multiple of 4");
  expect_fault("/bufferViews/0/byteStride", 252, "do not fit");
  expect_fault("/bufferViews/0/byteLength", 4000, "bufferViews[0]: bytes 0 to 4000 are outside buffers[0]");
  expect_fault("/bufferViews/0/byteOffset", 9007199254740992, "bufferViews[0]");
}

/// Counts without data behind them must not be allocated.
TEST_F(GltfBadInput, AbsurdCounts) {
  root_["accessors"][0].erase("bufferView");
  root_["accessors"][0]["count"] = 9007199254740992;
  expect_error("without a bufferView");
  root_ = valid_root_;
  root_["accessors"][0]["sparse"] = {{"count", 4000000000},
                                     {"indices", {{"bufferView", 0}, {"componentType", 5125}}},
                                     {"values", {{"bufferView", 0}}}};
  expect_error("do not fit");
  root_["accessors"][0]["sparse"]["count"] = 1;
  root_["accessors"][0]["sparse"]["indices"] = {{"bufferView", 0}, {"byteOffset", 12}, {"componentType", 5125}};
  expect_error("replaces element");
}

TEST_F(GltfBadInput, VertexIndicesOutOfRange) {
  primitive()["indices"] = add_accessor<std::uint16_t>({0, 1, 4}, 5123, "SCALAR", 1);
  expect_error("meshes[0].primitives[0]: index 2 is vertex 4 of 4");
}

TEST_F(GltfBadInput, AttributesOfDifferentLength) {
  primitive()["attributes"]["NORMAL"] = add_accessor<float>({0, 0, 1}, 5126, "VEC3", 3);
  expect_error("NORMAL: has 1 values for 4 vertices");
}

TEST_F(GltfBadInput, MissingBuffers) {
  const auto expect = [this](test::Json buffers, const std::string& fault) {
    test::Json root = root_;
    if (!buffers.is_null()) root["buffers"] = std::move(buffers);
    const std::string text = root.dump();
    expect_error(write("scene.gltf", {text.begin(), text.end()}), fault);
  };
  expect(nullptr, "bufferViews[0].buffer: 0 is out of range (the file has 0 buffers)");
  expect({{{"byteLength", bytes_.size()}, {"uri", "gone.bin"}}}, "gone.bin");
  // Only files beside the scene are read: a device has no end, and nothing is fetched.
  for (const char* uri : {"/dev/zero", "/dev/stdin", "../../../../../../../../dev/zero"})
    expect({{{"byteLength", bytes_.size()}, {"uri", uri}}}, "is no regular file");
  for (const char* uri : {"http://example.com/a.bin", "file:///etc/passwd", "ftp:a.bin"})
    expect({{{"byteLength", bytes_.size()}, {"uri", uri}}}, "is not read: only files beside the scene are");
  expect({{{"byteLength", 1000000}, {"uri", "data:;base64,AAAA"}}},
         "buffers[0]: has 3 bytes, byteLength promises 1000000");
  expect({{{"byteLength", 3}, {"uri", "data:;base64,!!!!"}}}, "not valid base64");
  expect({{{"byteLength", 3}, {"uri", "data:nothing"}}}, "no comma");
}

TEST_F(GltfBadInput, TablesOfMaterialsAreNoDevicesAndPipes) {
  ASSERT_EQ(::mkfifo(path("pipe.binary").c_str(), 0600), 0);
  for (const char* table : {"/dev/zero", "../../../../../../../../../../dev/stdin", "pipe.binary"}) {
    test::Json root = {{"asset", {{"version", "2.0"}}}};
    root["materials"] = {{{"name", "m"}, {"extras", {{"maquette", {{"measured", table}}}}}}};
    const std::string text = root.dump();
    expect_error(write("scene.gltf", {text.begin(), text.end()}), "is no regular file");
  }
}

/// A buffer without uri is valid, and its bytes are nowhere: what is made of it is left out.
TEST_F(GltfBadInput, ABufferWithoutUriLeavesOutItsPrimitives) {
  test::Json root = root_;
  root["buffers"] = test::Json::array({{{"byteLength", bytes_.size()}}});
  const std::string text = root.dump();
  const Scene scene = load_gltf(write("scene.gltf", {text.begin(), text.end()}));
  EXPECT_EQ(count_triangles(scene), 0u);
  expect_warning(scene, "meshes[0].primitives[0]: is made of a buffer that has no uri");
}

/// A missing image only removes its textures, not the scene.
TEST_F(GltfBadInput, MissingOrDamagedImages) {
  root_["images"] =
      test::Json::parse(R"([{"uri": "gone.png"}, {"uri": "data:image/png;base64,AAAA"}, {"bufferView": 0}, {}])");
  root_["textures"] = test::Json::parse(R"([{"source": 0}, {"source": 1}, {"source": 2}, {"source": 3}, {}])");
  root_["materials"] = test::Json::parse(R"([{"normalTexture": {"index": 0}, "emissiveTexture": {"index": 4}}])");
  primitive()["material"] = 0;
  const Scene scene = load();
  EXPECT_FALSE(scene.materials[0].normal_texture);
  EXPECT_FALSE(scene.materials[0].emissive_texture);
  expect_warning(scene, "images[0]: its textures are left out");
  expect_warning(scene, "images[1] and 1 more: its textures are left out: is not a PNG, JPEG or WebP");
  expect_warning(scene, "images[3]: its textures are left out");
  expect_warning(scene, "materials[0].emissiveTexture: a texture without a readable image");
  root_["materials"][0]["normalTexture"]["index"] = 8;
  expect_error("materials[0].normalTexture.index");
}

TEST_F(GltfBadInput, NodesThatAreNoTree) {
  root_["nodes"] = test::Json::parse(R"([{"children": [1]}, {"children": [0]}])");
  expect_error("is its own ancestor");
  root_["nodes"] = test::Json::parse(R"([{"children": [0]}])");
  expect_error("is its own ancestor");
  root_["nodes"] = test::Json::parse(R"([{"children": [2]}, {"children": [2]}, {}])");
  expect_error("nodes[2]: has two parents, 0 and 1");
  root_["nodes"] = test::Json::parse(R"([{}, {"children": [2]}, {}])");
  root_["scenes"][0]["nodes"] = {2};
  expect_error("its root 2 is a child of node 1");
}

TEST_F(GltfBadInput, AChainOfManyNodesIsFine) {
  const int count = 20000;
  for (int i = 1; i < count; ++i) {
    root_["nodes"].push_back(test::Json::object());
    root_["nodes"][static_cast<std::size_t>(i - 1)]["children"] = {i};
  }
  EXPECT_EQ(load().nodes.size(), static_cast<std::size_t>(count));
}

TEST_F(GltfBadInput, BadTransforms) {
  expect_fault("/nodes/0/matrix", {1, 2, 3}, "nodes[0].matrix: expected 16 numbers");
  expect_fault("/nodes/0/translation", {0, 1e30, 0}, "beyond 1e12");
  root_ = valid_root_;
  root_["nodes"][0]["rotation"] = {0, 0, 0, 0};
  root_["nodes"][0]["scale"] = {0, 0, 0};
  expect_warning(load(), "rotation of length zero");
}

TEST_F(GltfBadInput, PositionsThatAreNotFinite) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  primitive()["attributes"]["POSITION"] = add_accessor<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, nan, 1, 0}, 5126, "VEC3", 3);
  const Scene scene = load();
  EXPECT_EQ(count_triangles(scene), 1u);
  EXPECT_FLOAT_EQ(compute_bounds(scene).max.x, 1.0f);
  expect_warning(scene, "not finite");
  primitive()["attributes"]["POSITION"] = add_accessor<float>(std::vector<float>(12, nan), 5126, "VEC3", 3);
  const Scene none = load();
  EXPECT_EQ(count_triangles(none), 0u);
  EXPECT_TRUE(compute_bounds(none).empty());
  expect_warning(none, "nothing to see");
}

TEST_F(GltfBadInput, AttributesThatAreNotFinite) {
  const float inf = std::numeric_limits<float>::infinity();
  auto& attributes = primitive()["attributes"];
  attributes["NORMAL"] = add_accessor<float>(std::vector<float>(12, inf), 5126, "VEC3", 3);
  attributes["TEXCOORD_0"] = add_accessor<float>(std::vector<float>(8, inf), 5126, "VEC2", 2);
  attributes["COLOR_0"] = add_accessor<float>(std::vector<float>(16, inf), 5126, "VEC4", 4);
  const Scene scene = load();
  const Primitive& out = scene.meshes[0].primitives[0];
  EXPECT_EQ(out.normals[0], glm::vec3(0.0f));
  EXPECT_EQ(out.uvs[0][0], glm::vec2(0.0f));
  EXPECT_EQ(out.colors[0], glm::vec4(1.0f));
  expect_warning(scene, "attributes that are not finite");
}

TEST_F(GltfBadInput, TrianglesWithoutArea) {
  primitive()["indices"] = add_accessor<std::uint16_t>({0, 1, 2, 0, 0, 1, 3}, 5123, "SCALAR", 1);
  const Scene scene = load();
  expect_warning(scene, "zero area");
  expect_warning(scene, "not a multiple of three");
  EXPECT_EQ(count_triangles(scene), 2u);
}

TEST_F(GltfBadInput, NothingToSee) {
  const std::vector<char> bytes = std::exchange(bytes_, {});
  root_ = test::Json::parse(R"({"asset": {"version": "2.0"}})");
  expect_warning(load(), "nothing to see");
  root_ = valid_root_;
  bytes_ = bytes;
  root_["meshes"][0]["primitives"][0]["attributes"] = test::Json::object();
  expect_warning(load(), "has no POSITION");
}

TEST_F(GltfBadInput, ExtremeScales) {
  for (const double scale : {1e-6, 1e6}) {
    root_["nodes"][0]["scale"] = {scale, scale, scale};
    const Scene scene = load();
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_NEAR(compute_bounds(scene).max.x / scale, 1.0, 1e-5);
  }
}

TEST_F(GltfBadInput, BadMaterials) {
  root_["materials"] = test::Json::parse(R"([{"name": "m"}])");
  valid_root_ = root_;
  expect_fault("/materials/0/pbrMetallicRoughness", 3, "materials[0].pbrMetallicRoughness: expected an object");
  expect_fault("/materials/0/emissiveFactor", {1, 2}, "materials[0].emissiveFactor: expected 3 numbers");
  expect_fault("/materials/0/doubleSided", "yes", "materials[0].doubleSided: expected true or false");
  expect_fault("/materials/0/extras/maquette/measured", 5, "materials[0].extras.maquette.measured: expected text");
  root_ = valid_root_;
  root_["materials"][0] =
      test::Json::parse(R"({"alphaMode": "SHINY", "pbrMetallicRoughness": {"roughnessFactor": 7}})");
  const Scene scene = load();
  EXPECT_EQ(scene.materials[0].roughness, 1.0f);
  EXPECT_EQ(scene.materials[0].name, "material-0");
  expect_warning(scene, "roughnessFactor outside 0..1 is clamped");
  expect_warning(scene, "alphaMode \"SHINY\"");
}

TEST_F(GltfBadInput, BadVariants) {
  root_["materials"] = test::Json::parse("[{}]");
  primitive()["extensions"]["KHR_materials_variants"]["mappings"] =
      test::Json::parse(R"([{"material": 0, "variants": [0]}])");
  expect_error("meshes[0].primitives[0]: names variant 0 of 0");
}

TEST_F(GltfBadInput, BadExtras) {
  auto& cage = root_["meshes"][0]["extras"]["maquette"]["subdivision"];
  cage = test::Json::parse(
      R"({"positions": [0,0,0, 1,0,0, 1,1,0, 0,1,0], "face_sizes": [4], "face_indices": [0, 1, 2, 3]})");
  EXPECT_EQ(load().meshes[0].primitives[0].indices.size(), 6u * 16u);
  cage["face_indices"] = {0, 1, 2, 9};
  expect_error("meshes[0].extras.maquette.subdivision: subdivision cage: face 0 names a vertex that is not there");
  cage["face_indices"] = {0, 1, 2, 0.5};
  expect_error("subdivision.face_indices: holds a number that is no index");
  cage["face_indices"] = 77;
  expect_error("subdivision.face_indices: names an accessor that is not there");
  cage["face_indices"] = {0, 1, 2, 3};
  cage["levels"] = 99;
  expect_error("levels");
  root_ = valid_root_;
  root_["extras"]["maquette"]["bezier_patches"] = test::Json::parse(R"([{"points": [1, 2, 3]}])");
  expect_error("bezier_patches[0].points: has 1 points, expected 16");
  root_ = valid_root_;
  root_["nodes"][0]["extras"]["maquette"]["bezier_patch"] = 0;
  expect_error("nodes[0].extras.maquette.bezier_patch: is out of range");
}

/// Factors beyond what the specification allows are clamped, each with one warning that names the material.
TEST_F(GltfBadInput, FactorsOutOfRange) {
  primitive()["material"] = 0;
  root_["materials"] = test::Json::parse(R"([{"name": "m", "alphaMode": "MASK", "alphaCutoff": -0.5,
      "emissiveFactor": [0.5, 3, 1], "pbrMetallicRoughness": {"baseColorFactor": [1.5, 0.5, 0.5, 1],
      "metallicFactor": 1.5, "roughnessFactor": -0.5}, "extensions": {
        "KHR_materials_transmission": {"transmissionFactor": 2},
        "KHR_materials_volume": {"thicknessFactor": -1, "attenuationColor": [2, 1, 1]},
        "KHR_materials_clearcoat": {"clearcoatFactor": 4, "clearcoatRoughnessFactor": 2},
        "KHR_materials_specular": {"specularFactor": 2, "specularColorFactor": [4, 1, -1]},
        "KHR_materials_sheen": {"sheenColorFactor": [2, 0, 0], "sheenRoughnessFactor": 3},
        "KHR_materials_emissive_strength": {"emissiveStrength": -1},
        "KHR_materials_iridescence": {"iridescenceThicknessMaximum": -3}}}])");
  const Scene scene = load();
  for (const char* key : {"metallicFactor", "roughnessFactor", "transmissionFactor", "clearcoatFactor",
                          "specularFactor", "clearcoatRoughnessFactor", "sheenRoughnessFactor", "baseColorFactor",
                          "emissiveFactor", "sheenColorFactor", "attenuationColor"})
    expect_warning(scene, std::string(key) + " outside 0..1 is clamped");
  for (const char* key :
       {"alphaCutoff", "thicknessFactor", "specularColorFactor", "emissiveStrength", "iridescenceThicknessMaximum"})
    expect_warning(scene, std::string(key) + " below 0 is clamped");
  EXPECT_EQ(scene.warnings.size(), 1u);  // of materials[0]
  const Material& m = scene.materials[0];
  EXPECT_EQ(m.metallic, 1.0f);
  EXPECT_EQ(m.roughness, 0.0f);
  EXPECT_EQ(m.base_color.r, 1.0f);
  EXPECT_EQ(m.alpha_cutoff, 0.0f);
  EXPECT_EQ(m.specular_color, glm::vec3(4, 1, 0));
  EXPECT_EQ(m.thickness, 0.0f);
}

TEST_F(GltfBadInput, SamplersAndCoordinatesThatAreNotThere) {
  primitive()["material"] = 0;
  root_["images"] = test::Json::parse(
      R"([{"uri": "data:image/jpeg;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8/5+hHgAHggJ/PchI7wAAAABJRU5ErkJggg=="}])");
  root_["samplers"] = test::Json::parse(R"([{"magFilter": 7, "minFilter": 9985, "wrapS": 33648, "wrapT": 10496}])");
  root_["textures"] = test::Json::parse(R"([{"source": 0, "sampler": 0}])");
  root_["materials"] = test::Json::parse(R"([{"normalTexture": {"index": 0, "texCoord": 1},
      "emissiveTexture": {"index": 0, "texCoord": 1}}])");
  const Scene scene = load();
  EXPECT_EQ(scene.warnings.size(), 3u);
  expect_warning(scene, "magFilter is no code of glTF and taken as linear");
  expect_warning(scene, "wrapT is no code of glTF and taken as repeat");
  expect_warning(scene, "meshes[0].primitives[0]: its textures use TEXCOORD_1, which it does not have");
  expect_warning(scene, "images[0]: is a PNG image, although its data URI says otherwise");
  EXPECT_EQ(scene.materials[0].normal_texture.wrap_s, Wrap::mirrored_repeat);
  EXPECT_EQ(scene.materials[0].normal_texture.wrap_t, Wrap::repeat);
}

TEST_F(GltfBadInput, NodesWithoutNamesAreCalledByTheirIndex) {
  root_["nodes"][0]["scale"] = {1e30, 1, 1};
  expect_error("nodes[0]: its transform is not finite");
  root_["nodes"][0]["name"] = "huge";
  expect_error("node \"huge\": its transform is not finite");
}

/// What panes do not show of a material is named once.
TEST_F(GltfBadInput, LobesThatPanesDoNotHave) {
  primitive()["material"] = 0;
  root_["materials"] = test::Json::parse(R"([{"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1},
      "KHR_materials_clearcoat": {"clearcoatFactor": 1}, "KHR_materials_sheen": {"sheenColorFactor": [1, 0, 0]}},
      "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.5}}])");
  Scene scene = load();
  expect_warning(scene, "materials[0]: the share that transmits is drawn without clearcoat, sheen");
  expect_warning(scene, "; the share that transmits is drawn smooth");
  root_["materials"][0]["extensions"]["KHR_materials_unlit"] = test::Json::object();
  EXPECT_TRUE(load().warnings.empty());
}

}  // namespace
}  // namespace maquette
