#include <gtest/gtest.h>
#include <meshoptimizer.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "scenes/error.h"
#include "scenes/scene.h"

namespace maquette {
namespace {

using Json = nlohmann::json;

/// A file with one of everything that is read, its bytes in a data URI of percent-encoded text.
class Everything {
 public:
  Everything() {
    root_ = Json::parse(R"({"asset": {"version": "2.0"}, "scene": 0,
      "scenes": [{"name": "day", "nodes": [0, 1, 2, 4]}, {"nodes": [4]}],
      "nodes": [
        {"name": "skinned", "mesh": 0, "skin": 0, "weights": [0.5, 0.25], "translation": [1, 2, 3]},
        {"mesh": 0, "rotation": [0, 0, 0, 1], "scale": [1, 2, 3], "children": [3], "camera": 0,
         "extras": {"maquette": {"reflector": true, "visible": true, "bezier_patch": 0}}},
        {"matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1], "camera": 1, "extensions": {"KHR_lights_punctual": {"light": 0}}},
        {"mesh": 1, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {}}}},
        {"mesh": 2, "extensions": {"KHR_lights_punctual": {"light": 1}}}],
      "cameras": [{"type": "perspective", "name": "eye", "perspective": {"yfov": 0.5, "znear": 0.1, "zfar": 10, "aspectRatio": 1.5}},
        {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0.1, "zfar": 10}}],
      "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "color": [1, 0.5, 0.25], "intensity": 2, "range": 3,
          "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2}}, {"type": "directional"}]},
        "KHR_materials_variants": {"variants": [{"name": "a"}, {"name": "b"}]}},
      "extensionsUsed": ["KHR_lights_punctual", "ACME_unknown"],
      "samplers": [{"magFilter": 9728, "wrapS": 33071, "wrapT": 33648}],
      "textures": [{"source": 0, "sampler": 0}, {"source": 1}],
      "images": [{"name": "texel", "uri": "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mP8/5+hHgAHggJ/PchI7wAAAABJRU5ErkJggg=="}, {"uri": "gone.png"}],
      "materials": [{"name": "m", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.5], "metallicFactor": 0.5,
          "baseColorTexture": {"index": 0, "texCoord": 1, "extensions": {"KHR_texture_transform": {"offset": [0, 1], "scale": [2, 2], "rotation": 1, "texCoord": 0}}}},
          "normalTexture": {"index": 0, "scale": 2}, "emissiveFactor": [1, 2, 3], "alphaMode": "MASK", "alphaCutoff": 0.3, "doubleSided": true,
          "extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatTexture": {"index": 1}}, "KHR_materials_ior": {"ior": 1.3},
            "KHR_materials_volume": {"thicknessFactor": 1, "attenuationColor": [1, 1, 0], "attenuationDistance": 2}}}, {}],
      "animations": [{}],
      "extras": {"maquette": {"bezier_patches": [{"points": [0,0,0,1,0,0,2,0,0,3,0,0, 0,1,0,1,1,0,2,1,0,3,1,0, 0,2,0,1,2,0,2,2,0,3,2,0, 0,3,0,1,3,0,2,3,0,3,3,0],
          "name": "patch", "material": 0, "reflector": true}]}}})");
    const int positions = floats({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, 3, "VEC3");
    const int normals = floats({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3, "VEC3");
    const int uvs = floats({0, 0, 1, 0, 1, 1, 0, 1}, 2, "VEC2");
    const int weights = floats({1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0, 0, 1, 0, 0}, 4, "VEC4");
    const int joints = integers<std::uint8_t>({0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}, 5121, 4, "VEC4");
    const int colors = integers<std::uint8_t>(std::vector<std::uint8_t>(16, 200), 5121, 4, "VEC4");
    root_["accessors"].back()["normalized"] = true;
    const int indices = integers<std::uint16_t>({0, 1, 2, 0, 2, 3}, 5123, 1, "SCALAR");
    const int bound = floats(
        {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}, 16, "MAT4");
    root_["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", bound}, {"skeleton", 1}}};
    const int target = floats({0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 3, "VEC3");
    root_["accessors"].back()["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", view<std::uint16_t>({2})}, {"componentType", 5123}}},
        {"values", {{"bufferView", view<float>({1, 2, 3})}}}};
    const Json attributes = {{"POSITION", positions}, {"NORMAL", normals},  {"TEXCOORD_0", uvs},
                             {"COLOR_0", colors},     {"JOINTS_0", joints}, {"WEIGHTS_0", weights}};
    root_["meshes"] = {
        {{"name", "quad"},
         {"weights", {0, 1}},
         {"primitives",
          {{{"attributes", attributes},
            {"indices", indices},
            {"material", 0},
            {"mode", 4},
            {"targets", {{{"POSITION", target}, {"NORMAL", target}}, {{"POSITION", target}}}},
            {"extensions", {{"KHR_materials_variants", {{"mappings", {{{"material", 1}, {"variants", {1}}}}}}}}}}}}},
        {{"primitives", {{{"attributes", {{"POSITION", positions}, {"TEXCOORD_1", uvs}}}, {"mode", 5}}}}},
        {{"primitives", {{{"attributes", {{"POSITION", compressed()}}}}}},
         {"extras",
          {{"maquette",
            {{"subdivision",
              {{"positions", positions},
               {"face_sizes", {4}},
               {"face_indices", {0, 1, 2, 3}},
               {"crease_edges", {0, 1}},
               {"crease_sharpness", {2}},
               {"levels", 1}}}}}}}}};
    root_["nodes"][3]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", floats({0, 0, 0, 1, 1, 1}, 3, "VEC3")},
        {"ROTATION", floats({0, 0, 0, 1, 0, 0, 1, 0}, 4, "VEC4")}};
    std::string uri = "data:,";
    for (const char c : bytes_) {
      char text[4];
      std::snprintf(text, sizeof text, "%%%02x", static_cast<unsigned char>(c));
      uri += text;
    }
    root_["buffers"] = {{{"byteLength", bytes_.size()}, {"uri", uri}}, {{"byteLength", 48}}};
  }
  const Json& root() const { return root_; }

 private:
  template <typename T>
  int view(const std::vector<T>& values) {
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    root_["bufferViews"].push_back(
        {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", values.size() * sizeof(T)}});
    const auto* first = reinterpret_cast<const char*>(values.data());
    bytes_.insert(bytes_.end(), first, first + values.size() * sizeof(T));
    return static_cast<int>(root_["bufferViews"].size()) - 1;
  }
  template <typename T>
  int integers(const std::vector<T>& values, int type, std::size_t components, const char* name) {
    root_["accessors"].push_back({{"bufferView", view(values)},
                                  {"byteOffset", 0},
                                  {"componentType", type},
                                  {"count", values.size() / components},
                                  {"type", name}});
    return static_cast<int>(root_["accessors"].size()) - 1;
  }
  int floats(const std::vector<float>& values, std::size_t components, const char* name) {
    return integers(values, 5126, components, name);
  }
  /// Positions by EXT_meshopt_compression.
  int compressed() {
    const std::vector<float> points = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    std::vector<unsigned char> stream(meshopt_encodeVertexBufferBound(4, 12));
    stream.resize(meshopt_encodeVertexBuffer(stream.data(), stream.size(), points.data(), 4, 12));
    view(stream);
    Json& json = root_["bufferViews"].back();
    const Json offset = json["byteOffset"];
    json = {{"buffer", 1}, {"byteLength", 48}, {"byteStride", 12}};
    json["extensions"]["EXT_meshopt_compression"] = {
        {"buffer", 0},          {"byteOffset", offset}, {"byteLength", stream.size()}, {"byteStride", 12}, {"count", 4},
        {"mode", "ATTRIBUTES"}, {"filter", "NONE"}};
    const auto index = root_["bufferViews"].size() - 1;
    root_["accessors"].push_back({{"bufferView", index}, {"componentType", 5126}, {"count", 4}, {"type", "VEC3"}});
    return static_cast<int>(root_["accessors"].size()) - 1;
  }

  Json root_;
  std::vector<char> bytes_;
};

Json random_value(std::mt19937* random) {
  switch ((*random)() % 20) {
    case 0:
      return nullptr;
    case 1:
      return true;
    case 2:
      return "text";
    case 3:
      return std::string(3000, 'x');
    case 4:
      return Json::array();
    case 5:
      return Json::object();
    case 6:
      return -1;
    case 7:
      return 1e300;
    case 8:
      return -1e300;
    case 9:
      return 9007199254740992;
    case 10:
      return 18446744073709551615u;
    case 11:
      return 4294967296;
    case 12:
      return 2147483648;
    case 13:
      return 0.5;
    case 14:
      return Json::array({0, 1, 2});
    case 15:
      return Json::array({"a", nullptr, Json::object()});
    case 16:
      return 1e-40;
    case 17:
      return "line\nbreak";
    default:
      return (*random)() % 12;
  }
}

/// All values of the file but the elements of long lists of numbers.
std::vector<Json::json_pointer> places_of(const Json& root) {
  std::vector<Json::json_pointer> out;
  std::vector<Json::json_pointer> stack = {Json::json_pointer()};
  while (!stack.empty()) {
    const Json::json_pointer at = stack.back();
    stack.pop_back();
    if (!at.empty()) out.push_back(at);
    const Json& value = root[at];
    if (value.is_object())
      for (auto it = value.begin(); it != value.end(); ++it) stack.push_back(at / it.key());
    if (value.is_array())
      for (std::size_t i = 0; i < std::min<std::size_t>(value.size(), 16); ++i) stack.push_back(at / i);
  }
  return out;
}

void mutate(Json* root, const std::vector<Json::json_pointer>& places, std::mt19937* random) {
  const Json::json_pointer& at = places[(*random)() % places.size()];
  if (!root->contains(at)) return;  // an earlier change took it away
  if ((*random)() % 4 != 0) {
    (*root)[at] = random_value(random);
    return;
  }
  Json& parent = (*root)[at.parent_pointer()];
  if (parent.is_object()) parent.erase(at.back());
  if (parent.is_array()) parent.erase(parent.begin());
}

void expect_sound_members(const Scene& scene) {
  for (const Mesh& mesh : scene.meshes) {
    for (const Primitive& primitive : mesh.primitives) {
      for (const std::uint32_t index : primitive.indices) ASSERT_LT(index, primitive.positions.size());
      for (const glm::vec3& p : primitive.positions) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
      for (const std::size_t size : {primitive.normals.size(), primitive.tangents.size(), primitive.uvs[0].size(),
                                     primitive.uvs[1].size(), primitive.colors.size()})
        ASSERT_TRUE(size == 0 || size == primitive.positions.size());
      ASSERT_LT(primitive.material, static_cast<int>(scene.materials.size()));
    }
  }
  for (const Node& node : scene.nodes) {
    ASSERT_LT(node.mesh, static_cast<int>(scene.meshes.size()));
    ASSERT_LT(node.camera, static_cast<int>(scene.cameras.size()));
    ASSERT_LT(node.light, static_cast<int>(scene.lights.size()));
    ASSERT_LT(node.patch, static_cast<int>(scene.patches.size()));
    ASSERT_LT(node.parent, static_cast<int>(scene.nodes.size()));
  }
  for (const std::string& warning : scene.warnings) {
    ASSERT_EQ(warning.find('\n'), std::string::npos) << warning;
    ASSERT_EQ(warning.find(std::string(100, 'x')), std::string::npos);
  }
}

/// Members of wrong types, huge numbers, missing members: the file loads as a valid scene or one line says why not.
/// Another seed: --gtest_shuffle --gtest_random_seed=N.
TEST(GltfFuzz, WrongMembersLoadOrSayWhy) {
  const Json original = Everything().root();
  const std::vector<Json::json_pointer> places = places_of(original);
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("maquette-members-" + std::to_string(::getpid()) + ".gltf");
  const auto load = [&](const Json& root) {
    std::ofstream(path, std::ios::binary) << root.dump();
    return load_gltf(path.string());
  };
  const Scene whole = load(original);
  EXPECT_GT(count_triangles(whole), 8u);
  std::mt19937 random(static_cast<std::uint32_t>(::testing::UnitTest::GetInstance()->random_seed()) + 1);
  constexpr int kRounds = 3000;
  int loaded = 0;
  for (int round = 0; round < kRounds; ++round) {
    Json root = original;
    const int changes = 1 + static_cast<int>(random() % 3);
    for (int change = 0; change < changes; ++change) mutate(&root, places, &random);
    try {
      expect_sound_members(load(root));
      ++loaded;
    } catch (const Error& e) {
      const std::string line = e.what();
      ASSERT_EQ(line.find('\n'), std::string::npos) << line;
      ASSERT_LT(line.size(), 600u) << line;
      ASSERT_TRUE(line.starts_with(path.string()) || line.starts_with("--")) << line;
    }
    ASSERT_FALSE(::testing::Test::HasFatalFailure()) << root.dump().substr(0, 6000);
  }
  std::filesystem::remove(path);
  EXPECT_GT(loaded, kRounds / 10);
  EXPECT_LT(loaded, kRounds * 9 / 10);
}

}  // namespace
}  // namespace maquette
