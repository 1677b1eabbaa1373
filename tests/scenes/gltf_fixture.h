#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "scenes/error.h"
#include "scenes/scene.h"

namespace maquette::test {

using Json = nlohmann::json;

/// Builds small glTF files as JSON and bytes, in a separate folder that is removed at the end.
class GltfFixture : public ::testing::Test {
 protected:
  GltfFixture() {
    folder_ = std::filesystem::temp_directory_path() / ("maquette-gltf-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    root_ = Json::parse(R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "scene": 0,
        "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {}}]}]})");
  }
  ~GltfFixture() override { std::filesystem::remove_all(folder_); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  Json& primitive() { return root_["meshes"][0]["primitives"][0]; }

  template <typename T>
  int add_view(const std::vector<T>& values, std::size_t stride = 0) {
    bytes_.resize((bytes_.size() + 7) / 8 * 8);
    Json view = {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", values.size() * sizeof(T)}};
    if (stride != 0) view["byteStride"] = stride;
    const auto* first = reinterpret_cast<const char*>(values.data());
    bytes_.insert(bytes_.end(), first, first + values.size() * sizeof(T));
    root_["bufferViews"].push_back(view);
    return static_cast<int>(root_["bufferViews"].size()) - 1;
  }

  template <typename T>
  int add_accessor(const std::vector<T>& values, int component_type, const char* type, int components,
                   bool normalized = false) {
    Json accessor = {{"bufferView", add_view(values)},
                     {"componentType", component_type},
                     {"count", values.size() / static_cast<std::size_t>(components)},
                     {"type", type}};
    if (normalized) accessor["normalized"] = true;
    root_["accessors"].push_back(accessor);
    return static_cast<int>(root_["accessors"].size()) - 1;
  }

  /// The quad (0,0,0) (1,0,0) (1,1,0) (0,1,0) as two triangles.
  void add_quad() {
    primitive()["attributes"]["POSITION"] = add_accessor<float>({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, 5126, "VEC3", 3);
    primitive()["indices"] = add_accessor<std::uint16_t>({0, 1, 2, 0, 2, 3}, 5123, "SCALAR", 1);
  }

  std::vector<char> glb() const {
    Json root = root_;
    if (!bytes_.empty()) root["buffers"] = {{{"byteLength", bytes_.size()}}};
    std::string json = root.dump();
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::vector<char> binary = bytes_;
    binary.resize((binary.size() + 3) / 4 * 4);
    std::vector<char> file;
    const auto put = [&file](std::uint32_t value) {
      char four[4];
      std::memcpy(four, &value, 4);
      file.insert(file.end(), four, four + 4);
    };
    put(0x46546C67);
    put(2);
    put(static_cast<std::uint32_t>(20 + json.size() + (binary.empty() ? 0 : 8 + binary.size())));
    put(static_cast<std::uint32_t>(json.size()));
    put(0x4E4F534A);
    file.insert(file.end(), json.begin(), json.end());
    if (binary.empty()) return file;
    put(static_cast<std::uint32_t>(binary.size()));
    put(0x004E4942);
    file.insert(file.end(), binary.begin(), binary.end());
    return file;
  }

  std::string write(const std::string& name, const std::vector<char>& bytes) const {
    std::ofstream(path(name), std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return path(name);
  }
  std::string write_glb() const { return write("scene.glb", glb()); }
  Scene load() const { return load_gltf(write_glb()); }

  /// Expects one clear line that names the file and `fault`.
  void expect_error(const std::string& file, const std::string& fault) const {
    try {
      load_gltf(file);
      ADD_FAILURE() << "accepted in spite of: " << fault;
    } catch (const Error& e) {
      const std::string line = e.what();
      EXPECT_NE(line.find(file), std::string::npos) << line;
      EXPECT_NE(line.find(fault), std::string::npos) << line;
      EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    }
  }
  void expect_error(const std::string& fault) const { expect_error(write_glb(), fault); }

  static void expect_warning(const Scene& scene, const std::string& text) {
    int found = 0;
    for (const std::string& line : scene.warnings) found += line.find(text) != std::string::npos;
    EXPECT_EQ(found, 1) << text << " among " << scene.warnings.size() << " warnings"
                        << (scene.warnings.empty() ? "" : ", the first: " + scene.warnings[0]);
  }

  std::filesystem::path folder_;
  Json root_;
  std::vector<char> bytes_;
};

}  // namespace maquette::test
