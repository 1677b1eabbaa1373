#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "scenes/error.h"
#include "scenes/gltf_draco.h"
#include "scenes/subdivision.h"

namespace maquette {
namespace {

using Bytes = std::vector<char>;

constexpr int kDracoRounds = 1000;

Bytes read_bytes(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// A small scene with a cage, a patch, textures and variants, written by save_glb.
Scene small_scene() {
  Scene scene;
  scene.images.push_back({"texel", 1, 1, {1, 2, 3, 4}});
  scene.materials.resize(2);
  scene.materials[0].base_color_texture.image = 0;
  scene.materials[0].clearcoat = 0.5f;
  scene.materials[1].measured = "builtin:paint-solid-red";
  scene.variants = {"a", "b"};
  SubdivisionCage cage;
  cage.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0.5f}};
  cage.face_sizes = {4};
  cage.face_indices = {0, 1, 2, 3};
  cage.crease_edges = {{0, 1}};
  cage.crease_sharpness = {2.0f};
  Mesh& mesh = scene.meshes.emplace_back();
  mesh.cage = std::make_shared<const SubdivisionCage>(cage);
  tessellate_cage(&mesh);
  mesh.primitives[0].material = 0;
  mesh.primitives[0].variant_materials = {{1, 1}};
  scene.patches.emplace_back();
  scene.cameras.push_back({"eye", 0.8f, 0.1f, 10.0f});
  scene.lights.emplace_back();
  scene.nodes.resize(3);
  scene.nodes[0].mesh = 0;
  scene.nodes[0].children = {1, 2};
  scene.nodes[1].patch = 0;
  scene.nodes[1].parent = scene.nodes[2].parent = 0;
  scene.nodes[2].camera = scene.nodes[2].light = 0;
  scene.roots = {0};
  return scene;
}

void expect_sound(const Scene& scene) {
  for (const Mesh& mesh : scene.meshes) {
    for (const Primitive& primitive : mesh.primitives) {
      for (const std::uint32_t index : primitive.indices) ASSERT_LT(index, primitive.positions.size());
      for (const glm::vec3& p : primitive.positions) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
      ASSERT_LT(primitive.material, static_cast<int>(scene.materials.size()));
    }
  }
  for (const Node& node : scene.nodes) {
    ASSERT_LT(node.mesh, static_cast<int>(scene.meshes.size()));
    ASSERT_LT(node.patch, static_cast<int>(scene.patches.size()));
    ASSERT_LT(node.parent, static_cast<int>(scene.nodes.size()));
  }
}

/// Loads damaged copies: each must load as a valid scene or throw one line. Returns how many loaded.
int load_damaged(const Bytes& original, int rounds, std::uint32_t seed) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("maquette-fuzz-" + std::to_string(::getpid()) + ".glb");
  std::mt19937 random(seed);
  int loaded = 0;
  for (int round = 0; round < rounds; ++round) {
    Bytes bytes = original;
    const int flips = 1 + static_cast<int>(random() % 4);
    for (int flip = 0; flip < flips; ++flip) {
      char& byte = bytes[random() % bytes.size()];
      // Half of the time a digit becomes another digit: the damage then passes the JSON parser.
      byte = byte >= '0' && byte <= '9' && random() % 2 ? static_cast<char>('0' + random() % 10)
                                                        : static_cast<char>(random());
    }
    if (random() % 8 == 0) bytes.resize(random() % bytes.size());
    std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    try {
      expect_sound(load_gltf(path.string()));
      ++loaded;
    } catch (const Error& e) {
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    }
  }
  std::filesystem::remove(path);
  return loaded;
}

TEST(GltfFuzz, DamagedGlbLoadsOrSaysWhy) {
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("maquette-fuzz-seed-" + std::to_string(::getpid()) + ".glb");
  save_glb(path.string(), small_scene());
  const Bytes original = read_bytes(path);
  std::filesystem::remove(path);
  const int loaded = load_damaged(original, 1000, 1);
  EXPECT_GT(loaded, 100);  // the damage is not always fatal ...
  EXPECT_LT(loaded, 950);  // ... and not always harmless
}

/// A wavy sheet of 2 x 12 x 12 triangles as a Draco stream.
std::vector<std::byte> draco_sheet(int method) {
  const int side = 12;
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(2 * side * side);
  const int position = builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  std::uint32_t face = 0;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const auto at = [](int x, int y) {
        return glm::vec3(static_cast<float>(x), static_cast<float>(y), std::sin(static_cast<float>(x * y)));
      };
      const glm::vec3 a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      builder.SetAttributeValuesForFace(position, draco::FaceIndex(face++), &a[0], &b[0], &c[0]);
      builder.SetAttributeValuesForFace(position, draco::FaceIndex(face++), &a[0], &c[0], &d[0]);
    }
  }
  draco::Encoder encoder;
  encoder.SetEncodingMethod(method);
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 10);
  draco::EncoderBuffer buffer;
  EXPECT_TRUE(encoder.EncodeMeshToBuffer(*builder.Finalize(), &buffer).ok());
  const auto* first = reinterpret_cast<const std::byte*>(buffer.data());
  return {first, first + buffer.size()};
}

TEST(GltfFuzz, DamagedDracoDecodesOrSaysWhy) {
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    const std::vector<std::byte> original = draco_sheet(method);
    ASSERT_EQ(gltf::decode_draco("sheet", original, {{"POSITION", 0}}).indices.size(), 6u * 144u);
    std::mt19937 random(3);
    int refused = 0;
    for (int round = 0; round < kDracoRounds; ++round) {
      std::vector<std::byte> bytes = original;
      for (int flip = 0; flip < 3; ++flip) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
      try {
        const gltf::DracoMesh mesh = gltf::decode_draco("sheet", bytes, {{"POSITION", 0}});
        for (const std::uint32_t index : mesh.indices) ASSERT_LT(index, mesh.vertex_count);
        ASSERT_EQ(mesh.attributes.at("POSITION").values.size(), 3 * mesh.vertex_count);
      } catch (const Error&) {
        ++refused;
      }
    }
    EXPECT_GT(refused, kDracoRounds / 10);
  }
}

}  // namespace
}  // namespace maquette
