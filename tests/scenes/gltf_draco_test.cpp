#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>

#include <cmath>

#include "gltf_fixture.h"

namespace maquette {
namespace {

/// A closed box of 12 triangles through Draco's own encoder.
class GltfDraco : public test::GltfFixture {
 protected:
  void add_draco_box(int method) {
    draco::TriangleSoupMeshBuilder builder;
    builder.Start(12);
    const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    const int color = builder.AddAttribute(draco::GeometryAttribute::COLOR, 3, draco::DT_UINT8);
    std::uint32_t face = 0;
    for (int axis = 0; axis < 3; ++axis) {
      for (int side = 0; side < 2; ++side) {
        const auto corner = [&](int a, int b) {
          glm::vec3 p(0.0f);
          p[axis] = static_cast<float>(side);
          p[(axis + 1) % 3] = static_cast<float>(a);
          p[(axis + 2) % 3] = static_cast<float>(b);
          return p;
        };
        const glm::vec3 low = side ? corner(1, 0) : corner(0, 1), high = side ? corner(0, 1) : corner(1, 0);
        add_face(&builder, position, color, face++, corner(0, 0), low, corner(1, 1));
        add_face(&builder, position, color, face++, corner(0, 0), corner(1, 1), high);
      }
    }
    const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
    mesh->attribute(color)->set_normalized(true);
    draco::Encoder encoder;
    encoder.SetEncodingMethod(method);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 12);
    draco::EncoderBuffer buffer;
    ASSERT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
    view_ = add_view<char>({buffer.data(), buffer.data() + buffer.size()});
    root_["accessors"] = test::Json::parse(R"([{"componentType": 5125, "count": 36, "type": "SCALAR"},
      {"componentType": 5126, "count": 8, "type": "VEC3"}, {"componentType": 5121, "count": 8, "type": "VEC3", "normalized": true}])");
    root_["extensionsUsed"] = root_["extensionsRequired"] = {"KHR_draco_mesh_compression"};
    primitive() = {{"attributes", {{"POSITION", 1}, {"COLOR_0", 2}}}, {"indices", 0}};
    primitive()["extensions"]["KHR_draco_mesh_compression"] = {
        {"bufferView", view_},
        {"attributes",
         {{"POSITION", mesh->attribute(position)->unique_id()}, {"COLOR_0", mesh->attribute(color)->unique_id()}}}};
  }

  static void add_face(draco::TriangleSoupMeshBuilder* builder, int position, int color, std::uint32_t face,
                       const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    const std::uint8_t red[3] = {255, 51, 0};
    builder->SetAttributeValuesForFace(position, draco::FaceIndex(face), &a[0], &b[0], &c[0]);
    builder->SetAttributeValuesForFace(color, draco::FaceIndex(face), red, red, red);
  }

  const Primitive& loaded_primitive() {
    scene_ = load();
    return scene_.meshes.at(0).primitives.at(0);
  }

  int view_ = -1;
  Scene scene_;
};

TEST_F(GltfDraco, DecodesBothEncodings) {
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    add_draco_box(method);
    const Primitive& out = loaded_primitive();
    EXPECT_EQ(out.indices.size(), 36u);
    ASSERT_EQ(out.positions.size(), 24u);  // flat normals: the corners of six sides
    for (const glm::vec3& p : out.positions)
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(std::abs(p[c] - 0.5f), 0.5f, 1e-3f);
    ASSERT_EQ(out.colors.size(), 24u);
    EXPECT_LT(glm::distance(out.colors[3], glm::vec4(1.0f, 0.2f, 0.0f, 1.0f)), 1e-5f);
    EXPECT_TRUE(scene_.warnings.empty());
  }
}

TEST_F(GltfDraco, NamesDamage) {
  add_draco_box(draco::MESH_EDGEBREAKER_ENCODING);
  const test::Json valid_root = root_;
  const std::vector<char> bytes = bytes_;
  bytes_.assign(bytes.size(), 'x');
  expect_error("meshes[0].primitives[0]: its Draco data cannot be decoded");
  bytes_ = bytes;
  root_["bufferViews"][0]["byteLength"] = 20;
  expect_error("meshes[0].primitives[0]: its Draco data");
  root_ = valid_root;
  primitive()["extensions"]["KHR_draco_mesh_compression"]["attributes"]["POSITION"] = 77;
  expect_error("has no attribute 77");
  root_ = valid_root;
  primitive()["extensions"]["KHR_draco_mesh_compression"]["bufferView"] = 9;
  expect_error("bufferView: 9 is out of range");
}

/// One triangle whose texture coordinates and colours have the given type in the stream.
class GltfDracoMetadata : public test::GltfFixture {
 protected:
  template <typename T>
  void add_triangle(draco::DataType type, const std::array<T, 6>& uvs, const std::array<T, 12>& colors,
                    bool normalized_in_stream) {
    root_["accessors"].clear();
    root_["bufferViews"].clear();
    bytes_.clear();
    draco::TriangleSoupMeshBuilder builder;
    builder.Start(1);
    const float points[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    const int uv = builder.AddAttribute(draco::GeometryAttribute::GENERIC, 2, type);
    const int color = builder.AddAttribute(draco::GeometryAttribute::COLOR, 4, type);
    builder.SetAttributeValuesForFace(position, draco::FaceIndex(0), points, points + 3, points + 6);
    builder.SetAttributeValuesForFace(uv, draco::FaceIndex(0), &uvs[0], &uvs[2], &uvs[4]);
    builder.SetAttributeValuesForFace(color, draco::FaceIndex(0), &colors[0], &colors[4], &colors[8]);
    const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
    mesh->attribute(uv)->set_normalized(normalized_in_stream);
    mesh->attribute(color)->set_normalized(normalized_in_stream);
    draco::Encoder encoder;
    encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);
    draco::EncoderBuffer buffer;
    ASSERT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
    const int view = add_view<char>({buffer.data(), buffer.data() + buffer.size()});
    root_["accessors"] = test::Json::parse(R"([{"componentType": 5125, "count": 3, "type": "SCALAR"},
      {"componentType": 5126, "count": 3, "type": "VEC3"}, {"count": 3, "type": "VEC2"}, {"count": 3, "type": "VEC4"}])");
    primitive() = {{"attributes", {{"POSITION", 1}, {"TEXCOORD_0", 2}, {"COLOR_0", 3}}}, {"indices", 0}};
    primitive()["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", view},
                                                               {"attributes",
                                                                {{"POSITION", mesh->attribute(position)->unique_id()},
                                                                 {"TEXCOORD_0", mesh->attribute(uv)->unique_id()},
                                                                 {"COLOR_0", mesh->attribute(color)->unique_id()}}}};
  }
  void say(int component_type, bool normalized) {
    for (const std::size_t i : {2, 3}) {
      root_["accessors"][i]["componentType"] = component_type;
      root_["accessors"][i]["normalized"] = normalized;
    }
  }
  /// The vertex at (1, 0, 0): Draco may have another order.
  void expect_second(const glm::vec2& uv, const glm::vec4& color, std::size_t warnings = 0) {
    const Scene scene = load();
    EXPECT_EQ(scene.warnings.size(), warnings);
    const Primitive& out = scene.meshes.at(0).primitives.at(0);
    for (std::size_t i = 0; i < out.positions.size(); ++i) {
      if (out.positions[i] != glm::vec3(1, 0, 0)) continue;
      EXPECT_LT(glm::distance(out.uvs[0][i], uv), 1e-5f) << out.uvs[0][i].x << " " << out.uvs[0][i].y;
      EXPECT_LT(glm::distance(out.colors[i], color), 1e-5f) << out.colors[i].x << " " << out.colors[i].y;
      return;
    }
    ADD_FAILURE() << "no such vertex";
  }
};

/// The accessor says what integers mean, whatever the stream says.
TEST_F(GltfDracoMetadata, AccessorsSayWhatIntegersMean) {
  for (const bool in_stream : {false, true}) {
    add_triangle<std::uint8_t>(draco::DT_UINT8, {0, 0, 255, 51, 0, 255}, {0, 0, 0, 0, 255, 102, 51, 255, 9, 9, 9, 9},
                               in_stream);
    say(5121, true);
    expect_second({1.0f, 0.2f}, {1.0f, 0.4f, 0.2f, 1.0f});
    say(5121, false);  // texture coordinates by KHR_mesh_quantization; colours are always fractions
    expect_second({255.0f, 51.0f}, {1.0f, 0.4f, 0.2f, 1.0f}, 1);
    add_triangle<std::uint16_t>(draco::DT_UINT16, {0, 0, 65535, 13107, 0, 0},
                                {0, 0, 0, 0, 65535, 26214, 13107, 65535, 9, 9, 9, 9}, in_stream);
    say(5123, true);
    expect_second({1.0f, 0.2f}, {1.0f, 0.4f, 0.2f, 1.0f});
    add_triangle<std::int16_t>(draco::DT_INT16, {0, 0, -32768, 16384, 0, 0},
                               {0, 0, 0, 0, 32767, 0, 0, 32767, 9, 9, 9, 9}, in_stream);
    say(5122, true);
    expect_second({-1.0f, 16384.0f / 32767.0f}, {1.0f, 0.0f, 0.0f, 1.0f});
    say(5122, false);
    expect_second({-32768.0f, 16384.0f}, {1.0f, 0.0f, 0.0f, 1.0f}, 1);
  }
}

/// Where the accessor says floats, the stream says how its integers become some.
TEST_F(GltfDracoMetadata, FloatsOfIntegers) {
  add_triangle<std::uint8_t>(draco::DT_UINT8, {0, 0, 255, 51, 0, 255}, {0, 0, 0, 0, 255, 102, 51, 255, 9, 9, 9, 9},
                             true);
  say(5126, false);
  expect_second({1.0f, 0.2f}, {1.0f, 0.4f, 0.2f, 1.0f});
  add_triangle<float>(draco::DT_FLOAT32, {0, 0, 2, 0.25f, 0, 0}, {0, 0, 0, 0, 1, 0.5f, 0.25f, 1, 0, 0, 0, 0}, false);
  say(5126, false);
  expect_second({2.0f, 0.25f}, {1.0f, 0.5f, 0.25f, 1.0f});
}

TEST_F(GltfDracoMetadata, CountsThatContradict) {
  add_triangle<float>(draco::DT_FLOAT32, {0, 0, 2, 0.25f, 0, 0}, {0, 0, 0, 0, 1, 0.5f, 0.25f, 1, 0, 0, 0, 0}, false);
  say(5126, false);
  for (const int wrong : {0, 1, 2, 3}) {
    for (std::size_t i = 0; i < 4; ++i) root_["accessors"][i]["count"] = i == static_cast<std::size_t>(wrong) ? 9 : 3;
    const Scene scene = load();
    expect_warning(scene, "meshes[0].primitives[0]: the counts of its accessors contradict its Draco data");
    EXPECT_EQ(scene.warnings.size(), 1u);
    EXPECT_EQ(count_triangles(scene), 1u);
  }
}

}  // namespace
}  // namespace maquette
