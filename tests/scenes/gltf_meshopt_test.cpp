#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <cmath>
#include <random>

#include "gltf_fixture.h"

namespace maquette {
namespace {

/// EXT_meshopt_compression through the library's own encoders. Buffer 1 is the fallback without bytes.
class GltfMeshopt : public test::GltfFixture {
 protected:
  GltfMeshopt() { root_["extensionsUsed"] = root_["extensionsRequired"] = {"EXT_meshopt_compression"}; }

  int add_stream(std::vector<unsigned char> stream, std::size_t count, std::size_t stride, const char* mode,
                 const char* filter = nullptr) {
    const int view = add_view(stream);
    test::Json& json = root_["bufferViews"].back();
    test::Json compressed = {{"buffer", 0},
                             {"byteOffset", json["byteOffset"]},
                             {"byteLength", stream.size()},
                             {"byteStride", stride},
                             {"count", count},
                             {"mode", mode}};
    if (filter != nullptr) compressed["filter"] = filter;
    json = {{"buffer", 1}, {"byteOffset", fallback_bytes_}, {"byteLength", count * stride}};
    if (std::string(mode) == "ATTRIBUTES") json["byteStride"] = stride;
    json["extensions"]["EXT_meshopt_compression"] = compressed;
    fallback_bytes_ += (count * stride + 3) / 4 * 4;
    return view;
  }
  template <typename T>
  int add_vertices(const std::vector<T>& values, std::size_t per_vertex, const char* filter = nullptr) {
    const std::size_t count = values.size() / per_vertex, stride = per_vertex * sizeof(T);
    std::vector<unsigned char> out(meshopt_encodeVertexBufferBound(count, stride));
    out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), values.data(), count, stride));
    return add_stream(out, count, stride, "ATTRIBUTES", filter);
  }
  int add_triangles(const std::vector<unsigned>& indices, std::size_t vertex_count, std::size_t stride) {
    std::vector<unsigned char> out(meshopt_encodeIndexBufferBound(indices.size(), vertex_count));
    out.resize(meshopt_encodeIndexBuffer(out.data(), out.size(), indices.data(), indices.size()));
    return add_stream(out, indices.size(), stride, "TRIANGLES");
  }
  int add_sequence(const std::vector<unsigned>& indices, std::size_t vertex_count, std::size_t stride) {
    std::vector<unsigned char> out(meshopt_encodeIndexSequenceBound(indices.size(), vertex_count));
    out.resize(meshopt_encodeIndexSequence(out.data(), out.size(), indices.data(), indices.size()));
    return add_stream(out, indices.size(), stride, "INDICES");
  }
  int accessor(int view, int component_type, const char* type, std::size_t count, bool normalized = false) {
    root_["accessors"].push_back({{"bufferView", view},
                                  {"componentType", component_type},
                                  {"count", count},
                                  {"type", type},
                                  {"normalized", normalized}});
    return static_cast<int>(root_["accessors"].size()) - 1;
  }
  std::string write_scene(const test::Json& fallback = test::Json()) {
    const std::vector<char> bytes = bytes_;
    write("data.bin", bytes);
    test::Json root = root_;
    test::Json buffer = fallback.is_null() ? test::Json::object() : fallback;
    buffer["byteLength"] = fallback_bytes_;
    buffer["extensions"]["EXT_meshopt_compression"]["fallback"] = true;
    root["buffers"] = {{{"byteLength", bytes.size()}, {"uri", "data.bin"}}, buffer};
    const std::string text = root.dump();
    return write("scene.gltf", {text.begin(), text.end()});
  }
  /// The quad, its positions and triangles compressed.
  void add_compressed_quad(std::size_t index_stride = 2) {
    primitive()["attributes"]["POSITION"] =
        accessor(add_vertices<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0.5f}, 3), 5126, "VEC3", 4);
    primitive()["indices"] =
        accessor(add_triangles({0, 1, 2, 0, 2, 3}, 4, index_stride), index_stride == 2 ? 5123 : 5125, "SCALAR", 6);
  }
  std::size_t fallback_bytes_ = 0;
};

/// Corners of both triangles, whatever the order that the encoder gave them.
std::vector<std::vector<std::uint32_t>> sorted_triangles(const Primitive& p) {
  std::vector<std::vector<std::uint32_t>> out;
  for (std::size_t i = 0; i < p.indices.size(); i += 3) {
    std::vector<std::uint32_t> t(p.indices.begin() + static_cast<std::ptrdiff_t>(i),
                                 p.indices.begin() + static_cast<std::ptrdiff_t>(i) + 3);
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    out.push_back(t);
  }
  std::sort(out.begin(), out.end());
  return out;
}

TEST_F(GltfMeshopt, AttributesAndTriangles) {
  for (const std::size_t stride : {2, 4}) {
    root_["bufferViews"].clear();
    root_["accessors"].clear();
    add_compressed_quad(stride);
    primitive()["attributes"]["NORMAL"] =
        accessor(add_vertices<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 3), 5126, "VEC3", 4);
    const Scene scene = load_gltf(write_scene());
    EXPECT_TRUE(scene.warnings.empty());
    const Primitive& out = scene.meshes[0].primitives[0];
    EXPECT_EQ(out.positions, (std::vector<glm::vec3>{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.5f}}));
    EXPECT_EQ(sorted_triangles(out), (std::vector<std::vector<std::uint32_t>>{{0, 1, 2}, {0, 2, 3}}));
  }
}

TEST_F(GltfMeshopt, SequencesOfIndices) {
  add_compressed_quad();
  primitive()["mode"] = 5;
  primitive()["indices"] = accessor(add_sequence({0, 1, 3, 2}, 4, 4), 5125, "SCALAR", 4);
  EXPECT_EQ(load_gltf(write_scene()).meshes[0].primitives[0].indices.size(), 6u);
  primitive()["indices"] = accessor(add_sequence({0, 1, 3, 2}, 4, 2), 5123, "SCALAR", 4);
  EXPECT_EQ(count_triangles(load_gltf(write_scene())), 2u);
}

/// Directions by octahedra of 8 and 16 bits.
TEST_F(GltfMeshopt, OctahedralFilter) {
  add_compressed_quad();
  const std::vector<float> normals = {0, 0, 1, 0, 0.6f, 0, 0.8f, 0, -0.48f, 0.6f, -0.64f, 0, 0, -1, 0, 0};
  for (const std::size_t stride : {4, 8}) {
    std::vector<std::uint8_t> bytes(4 * stride);
    meshopt_encodeFilterOct(bytes.data(), 4, stride, stride == 4 ? 8 : 16, normals.data());
    primitive()["attributes"]["NORMAL"] =
        accessor(add_vertices(bytes, stride, "OCTAHEDRAL"), stride == 4 ? 5120 : 5122, "VEC3", 4, true);
    const Primitive out = load_gltf(write_scene()).meshes[0].primitives[0];
    for (std::size_t i = 0; i < 4; ++i)
      EXPECT_LT(glm::distance(out.normals[i], glm::vec3(normals[4 * i], normals[4 * i + 1], normals[4 * i + 2])),
                stride == 4 ? 2e-2f : 1e-4f);
  }
}

TEST_F(GltfMeshopt, ExponentialFilter) {
  add_compressed_quad();
  const std::vector<float> points = {0, 0, 0, 1000.25f, 0, 0, 1, -0.001f, 0, 0, 1, 3e-7f};
  std::vector<std::uint32_t> words(12);
  meshopt_encodeFilterExp(words.data(), 4, 12, 20, points.data());
  primitive()["attributes"]["POSITION"] = accessor(add_vertices(words, 3, "EXPONENTIAL"), 5126, "VEC3", 4);
  const Primitive out = load_gltf(write_scene()).meshes[0].primitives[0];
  for (std::size_t i = 0; i < 4; ++i)
    for (int c = 0; c < 3; ++c) {
      const float expected = points[3 * i + static_cast<std::size_t>(c)];
      EXPECT_NEAR(out.positions[i][c], expected, 1e-5f * (1.0f + std::abs(points[3 * i])));
    }
}

/// Rotations of instances by the quaternion filter.
TEST_F(GltfMeshopt, QuaternionFilter) {
  add_compressed_quad();
  const float half = std::sqrt(0.5f);
  const std::vector<float> rotations = {0, 0, 0, 1, 0, 0, half, half};
  std::vector<std::uint16_t> words(8);
  meshopt_encodeFilterQuat(words.data(), 2, 8, 16, rotations.data());
  root_["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["ROTATION"] =
      accessor(add_vertices(words, 4, "QUATERNION"), 5122, "VEC4", 2, true);
  const Scene scene = load_gltf(write_scene());
  ASSERT_EQ(scene.nodes.size(), 3u);
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  EXPECT_LT(glm::distance(glm::vec3(world[1] * glm::vec4(1, 0, 0, 1)), glm::vec3(1, 0, 0)), 1e-3f);
  EXPECT_LT(glm::distance(glm::vec3(world[2] * glm::vec4(1, 0, 0, 1)), glm::vec3(0, 1, 0)), 1e-3f);
}

/// The fallback's own bytes are not needed, whether it names some or not.
TEST_F(GltfMeshopt, FallbackBuffers) {
  add_compressed_quad();
  EXPECT_EQ(count_triangles(load_gltf(write_scene())), 2u);
  EXPECT_EQ(count_triangles(load_gltf(write_scene({{"uri", "gone.bin"}}))), 2u);
  // A view of the fallback that is not compressed has no bytes.
  root_["bufferViews"][0].erase("extensions");
  expect_warning(load_gltf(write_scene()), "is made of a buffer that has no uri");
}

TEST_F(GltfMeshopt, BadStreams) {
  add_compressed_quad();
  const test::Json valid = root_;
  const auto expect = [&](const char* member, const test::Json& value, const std::string& fault) {
    root_ = valid;
    root_["bufferViews"][0]["extensions"]["EXT_meshopt_compression"][member] = value;
    expect_error(write_scene(), fault);
  };
  expect("buffer", 7, "bufferViews[0].extensions.EXT_meshopt_compression.buffer: 7 is out of range");
  expect("byteLength", 100000, "its bytes are outside buffers[0]");
  expect("byteOffset", 9007199254740992, "its bytes are outside buffers[0]");
  expect("byteLength", 10, "bufferViews[0].EXT_meshopt_compression");
  expect("count", 2000000000, "does not hold the 2000000000 elements");
  expect("count", 5, "has 60 bytes, byteLength promises 48");
  expect("byteStride", 7, "do not go together");
  expect("byteStride", 0, "do not go together");
  expect("byteStride", 512, "do not go together");
  expect("mode", "TRIANGLES", "do not go together");
  expect("mode", "POINTS", "mode \"POINTS\" is not one");
  expect("filter", "OCTAHEDRAL", "do not go together");
  expect("filter", "SMOOTH", "filter \"SMOOTH\"");
  expect("mode", 3, "mode: expected text");
  root_ = valid;
  root_["bufferViews"][0]["extensions"]["EXT_meshopt_compression"].erase("count");
  expect_error(write_scene(), "count: is missing");
}

/// Damaged streams decode to something or say so.
TEST_F(GltfMeshopt, DamagedStreams) {
  add_compressed_quad();
  const std::vector<char> bytes = bytes_;
  std::mt19937 random(7);
  int loaded = 0;
  for (int round = 0; round < 500; ++round) {
    bytes_ = bytes;
    for (int flip = 0; flip < 3; ++flip) bytes_[random() % bytes_.size()] = static_cast<char>(random());
    try {
      const Scene scene = load_gltf(write_scene());
      for (const std::uint32_t index : scene.meshes[0].primitives[0].indices)
        ASSERT_LT(index, scene.meshes[0].primitives[0].positions.size());
      ++loaded;
    } catch (const Error&) {
    }
  }
  EXPECT_GT(loaded, 10);
  EXPECT_LT(loaded, 490);
}

}  // namespace
}  // namespace maquette
