#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "gltf_fixture.h"

namespace maquette {
namespace {

class GltfGeometry : public test::GltfFixture {
 protected:
  const Primitive& loaded_primitive() {
    scene_ = load();
    return scene_.meshes.at(0).primitives.at(0);
  }
  Scene scene_;
};

glm::vec3 face_normal(const Primitive& p, std::size_t triangle) {
  const glm::vec3 a = p.positions[p.indices[3 * triangle]], b = p.positions[p.indices[3 * triangle + 1]],
                  c = p.positions[p.indices[3 * triangle + 2]];
  return glm::normalize(glm::cross(b - a, c - a));
}

/// glTF 2.0, 3.7.2.1: without normals, those of the triangles.
TEST_F(GltfGeometry, MissingNormalsAreFlat) {
  // A roof: its ridge from (0, 0, 1) to (0, 1, 1) is shared by both sides, of two triangles each.
  primitive()["attributes"]["POSITION"] =
      add_accessor<float>({-1, 0, 0, 0, 0, 1, 0, 1, 1, -1, 1, 0, 1, 0, 0, 1, 1, 0}, 5126, "VEC3", 3);
  primitive()["attributes"]["TEXCOORD_1"] = add_accessor<float>({0, 0, 1, 0, 1, 1, 0, 1, 2, 0, 2, 1}, 5126, "VEC2", 2);
  primitive()["attributes"]["COLOR_0"] = add_accessor<float>(std::vector<float>(18, 0.5f), 5126, "VEC3", 3);
  primitive()["attributes"]["TANGENT"] = add_accessor<float>(std::vector<float>(24, 1.0f), 5126, "VEC4", 4);
  primitive()["indices"] = add_accessor<std::uint16_t>({0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2}, 5123, "SCALAR", 1);
  const Primitive& out = loaded_primitive();
  EXPECT_TRUE(scene_.warnings.empty());
  ASSERT_EQ(out.indices.size(), 12u);
  EXPECT_EQ(out.positions.size(), 8u);  // the ridge twice, the rest once: the sides are plane
  EXPECT_EQ(out.normals.size(), 8u);
  EXPECT_EQ(out.uvs[1].size(), 8u);
  EXPECT_EQ(out.colors.size(), 8u);
  EXPECT_TRUE(out.tangents.empty());
  const float half = std::sqrt(0.5f);
  for (std::size_t i = 0; i < 12; ++i) {
    const glm::vec3 expected(i < 6 ? -half : half, 0.0f, half);
    EXPECT_LT(glm::distance(out.normals[out.indices[i]], expected), 1e-6f) << i;
    EXPECT_EQ(out.uvs[1][out.indices[i]].x, out.positions[out.indices[i]].x + 1.0f);
  }
}

/// A cone of many sides has one normal a side, in time that grows with their number.
TEST_F(GltfGeometry, FlatConesOfManySides) {
  const std::size_t sides = 200000;
  std::vector<float> points = {0, 0, 1};
  std::vector<std::uint32_t> indices;
  for (std::size_t i = 0; i < sides; ++i) {
    const double angle = 2.0 * 3.14159265358979 * static_cast<double>(i) / static_cast<double>(sides);
    points.insert(points.end(),
                  {static_cast<float>(1e3 * std::cos(angle)), static_cast<float>(1e3 * std::sin(angle)), 0});
    const auto a = static_cast<std::uint32_t>(i + 1), b = static_cast<std::uint32_t>((i + 1) % sides + 1);
    indices.insert(indices.end(), {0, a, b});
  }
  primitive()["attributes"]["POSITION"] = add_accessor<float>(points, 5126, "VEC3", 3);
  primitive()["indices"] = add_accessor<std::uint32_t>(indices, 5125, "SCALAR", 1);
  const Primitive& out = loaded_primitive();
  ASSERT_EQ(out.indices.size(), indices.size());
  for (std::size_t t = 0; t < sides; t += 997)
    for (std::size_t corner = 0; corner < 3; ++corner)
      ASSERT_LT(glm::distance(out.normals[out.indices[3 * t + corner]], face_normal(out, t)), 1e-4f) << t;
}

TEST_F(GltfGeometry, FlatNormalsOfEdges) {
  // A triangle without area takes no side; a vertex of its own keeps a normal that is drawn later.
  primitive()["attributes"]["POSITION"] = add_accessor<float>({0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 0, 0}, 5126, "VEC3", 3);
  primitive()["indices"] = add_accessor<std::uint16_t>({0, 1, 3, 0, 1, 2}, 5123, "SCALAR", 1);
  const Primitive& out = loaded_primitive();
  EXPECT_EQ(out.positions.size(), 4u);
  EXPECT_EQ(out.normals[0], glm::vec3(0, 0, 1));
  EXPECT_EQ(out.normals[3], glm::vec3(0));
  // Normals of the file stay.
  primitive()["attributes"]["NORMAL"] = add_accessor<float>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1}, 5126, "VEC3", 3);
  EXPECT_EQ(loaded_primitive().normals[0], glm::vec3(1, 0, 0));
}

/// The limit surface of a cage keeps its exact, smooth normals.
TEST_F(GltfGeometry, CagesStaySmooth) {
  add_quad();
  root_["meshes"][0]["extras"]["maquette"]["subdivision"] = test::Json::parse(
      R"({"positions": [0,0,0, 1,0,0, 1,1,1, 0,1,0], "face_sizes": [4], "face_indices": [0, 1, 2, 3], "vertex_count": 4})");
  const Primitive& out = loaded_primitive();
  EXPECT_EQ(out.indices.size(), 6u * 16u);
  EXPECT_EQ(out.normals.size(), out.positions.size());
  EXPECT_EQ(out.positions.size(), 25u);
}

TEST_F(GltfGeometry, ColoursOfAllTypes) {
  add_quad();
  auto& attributes = primitive()["attributes"];
  const auto expect = [&](int accessor, const glm::vec4& color, std::size_t warnings) {
    attributes["COLOR_0"] = accessor;
    const Primitive& out = loaded_primitive();
    EXPECT_EQ(scene_.warnings.size(), warnings);
    ASSERT_EQ(out.colors.size(), 4u);
    EXPECT_LT(glm::distance(out.colors[1], color), 1e-6f);
  };
  expect(add_accessor<float>({0, 0, 0, 2, 0.4f, 0.2f, 0, 0, 0, 0, 0, 0}, 5126, "VEC3", 3), {2, 0.4f, 0.2f, 1}, 0);
  expect(add_accessor<std::uint16_t>({0, 0, 0, 0, 65535, 26214, 13107, 6553, 0, 0, 0, 0, 0, 0, 0, 0}, 5123, "VEC4", 4,
                                     true),
         {1, 0.4f, 0.2f, 6553.0f / 65535.0f}, 0);
  std::vector<std::uint8_t> bytes = {0, 0, 0, 0, 255, 102, 51, 0, 0, 0, 0, 0, 0, 0, 0, 0};
  const int rgb = add_accessor<std::uint8_t>(bytes, 5121, "VEC3", 4, true);  // rows of four bytes
  root_["bufferViews"].back()["byteStride"] = 4;
  expect(rgb, {1, 0.4f, 0.2f, 1}, 0);
  expect(add_accessor<std::uint8_t>(bytes, 5121, "VEC4", 4, false), {1, 0.4f, 0.2f, 0}, 1);
  expect_warning(scene_, "meshes[0].primitives[0]: COLOR_0 of integers that are not normalized");
}

/// KHR_mesh_quantization: every type of its table, normalised or not.
TEST_F(GltfGeometry, QuantizedTypes) {
  add_quad();
  auto& attributes = primitive()["attributes"];
  root_["extensionsUsed"] = root_["extensionsRequired"] = {"KHR_mesh_quantization"};
  const auto points = [&](auto values, int type, bool normalized) {
    attributes["POSITION"] = add_accessor(values, type, "VEC3", 4, normalized);
    root_["bufferViews"].back()["byteStride"] = 4 * sizeof(values[0]);
    return loaded_primitive().positions[1];
  };
  using I8 = std::vector<std::int8_t>;
  using U8 = std::vector<std::uint8_t>;
  using I16 = std::vector<std::int16_t>;
  using U16 = std::vector<std::uint16_t>;
  EXPECT_EQ(points(I8{0, 0, 0, 0, -128, 127, 1, 0, 0, 9, 0, 0, 9, 0, 0, 0}, 5120, true), glm::vec3(-1, 1, 1 / 127.0f));
  EXPECT_EQ(points(I8{0, 0, 0, 0, -128, 127, 1, 0, 0, 9, 0, 0, 9, 0, 0, 0}, 5120, false), glm::vec3(-128, 127, 1));
  EXPECT_EQ(points(U8{0, 0, 0, 0, 255, 51, 0, 0, 0, 9, 0, 0, 9, 0, 0, 0}, 5121, true), glm::vec3(1, 0.2f, 0));
  EXPECT_EQ(points(U8{0, 0, 0, 0, 255, 51, 0, 0, 0, 9, 0, 0, 9, 0, 0, 0}, 5121, false), glm::vec3(255, 51, 0));
  EXPECT_EQ(points(I16{0, 0, 0, 0, -32768, 32767, 0, 0, 0, 9, 0, 0, 9, 0, 0, 0}, 5122, true), glm::vec3(-1, 1, 0));
  EXPECT_EQ(points(I16{0, 0, 0, 0, -300, 7, 0, 0, 0, 9, 0, 0, 9, 0, 0, 0}, 5122, false), glm::vec3(-300, 7, 0));
  EXPECT_EQ(points(U16{0, 0, 0, 0, 65535, 13107, 0, 0, 0, 9, 0, 0, 9, 0, 0, 0}, 5123, true), glm::vec3(1, 0.2f, 0));
  EXPECT_EQ(points(U16{0, 0, 0, 0, 40000, 7, 0, 0, 0, 9, 0, 0, 9, 0, 0, 0}, 5123, false), glm::vec3(40000, 7, 0));
}

TEST_F(GltfGeometry, FurtherSetsAreNamedOnce) {
  add_quad();
  const int uv = add_accessor<float>({0, 0, 1, 0, 1, 1, 0, 1}, 5126, "VEC2", 2);
  for (const char* name : {"TEXCOORD_0", "TEXCOORD_1", "TEXCOORD_2"}) primitive()["attributes"][name] = uv;
  root_["meshes"][0]["primitives"].push_back(primitive());
  const Scene scene = load();
  EXPECT_EQ(scene.warnings.size(), 1u);
  expect_warning(scene, "meshes[0].primitives[0] and 1 more: the vertex attribute TEXCOORD_2 is ignored");
}

}  // namespace
}  // namespace maquette
