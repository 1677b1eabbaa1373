#include "tests/support/compressed_glb.h"

#include <draco/compression/encode.h>
#include <draco/mesh/mesh.h>
#include <meshoptimizer.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

namespace maquette::test {
namespace {

using Json = nlohmann::json;
constexpr std::size_t kHeader = 12, kChunkHeader = 8;
constexpr int kShort = 5123;

/// A binary glTF file whose geometry is replaced.
class Compressor {
 public:
  explicit Compressor(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    const std::vector<char> file{std::istreambuf_iterator<char>(in), {}};
    const std::size_t json_size = number(file, kHeader);
    root_ = Json::parse(file.begin() + kHeader + kChunkHeader,
                        file.begin() + static_cast<std::ptrdiff_t>(kHeader + kChunkHeader + json_size));
    const std::size_t binary = kHeader + 2 * kChunkHeader + json_size;
    bytes_.assign(file.begin() + static_cast<std::ptrdiff_t>(binary), file.end());
  }

  void compress_by_draco() {
    for (Json& mesh : root_["meshes"])
      for (Json& primitive : mesh["primitives"]) draco_primitive(&primitive);
    use("KHR_draco_mesh_compression");
  }

  void compress_by_meshopt() {
    std::map<int, bool> done;  // by bufferView
    for (Json& mesh : root_["meshes"])
      for (Json& primitive : mesh["primitives"]) {
        std::size_t vertex_count = 0;
        for (const auto& [name, index] : primitive["attributes"].items()) {
          vertex_count = accessor(index)["count"];
          if (!std::exchange(done[view_of(index)], true)) meshopt_vertices(index);
        }
        if (!std::exchange(done[view_of(primitive["indices"])], true))
          meshopt_indices(primitive["indices"], vertex_count);
      }
    use("EXT_meshopt_compression");
    root_["buffers"].push_back({{"byteLength", fallback_bytes_}});
    root_["buffers"].back()["extensions"]["EXT_meshopt_compression"]["fallback"] = true;
  }

  void write(const std::string& path) {
    root_["buffers"][0]["byteLength"] = bytes_.size();
    std::string json = root_.dump();
    json.resize((json.size() + 3) / 4 * 4, ' ');
    bytes_.resize((bytes_.size() + 3) / 4 * 4);
    std::vector<char> file;
    const auto put = [&file](std::size_t value) {
      const auto word = static_cast<std::uint32_t>(value);
      file.insert(file.end(), reinterpret_cast<const char*>(&word), reinterpret_cast<const char*>(&word) + 4);
    };
    put(0x46546C67);
    put(2);
    put(kHeader + 2 * kChunkHeader + json.size() + bytes_.size());
    put(json.size());
    put(0x4E4F534A);
    file.insert(file.end(), json.begin(), json.end());
    put(bytes_.size());
    put(0x004E4942);
    file.insert(file.end(), bytes_.begin(), bytes_.end());
    std::ofstream(path, std::ios::binary).write(file.data(), static_cast<std::streamsize>(file.size()));
  }

 private:
  static std::size_t number(const std::vector<char>& file, std::size_t at) {
    std::uint32_t word = 0;
    if (file.size() < at + 4) throw std::runtime_error("no binary glTF file");
    std::memcpy(&word, file.data() + at, 4);
    return word;
  }

  Json& accessor(const Json& index) { return root_["accessors"][index.get<std::size_t>()]; }
  int view_of(const Json& index) { return accessor(index)["bufferView"]; }
  void use(const char* extension) {
    root_["extensionsUsed"].push_back(extension);
    root_["extensionsRequired"].push_back(extension);
  }

  static std::size_t components(const Json& accessor) {
    const std::string type = accessor["type"];
    return type == "SCALAR" ? 1 : static_cast<std::size_t>(type.back() - '0');
  }

  const char* bytes_of(const Json& accessor) {
    return bytes_.data() +
           root_["bufferViews"][accessor["bufferView"].get<std::size_t>()]["byteOffset"].get<std::size_t>();
  }

  std::vector<float> floats(const Json& index) {
    const Json& a = accessor(index);
    std::vector<float> out(a["count"].get<std::size_t>() * components(a));
    std::memcpy(out.data(), bytes_of(a), out.size() * sizeof(float));
    return out;
  }

  std::vector<unsigned> indices(const Json& index) {
    const Json& a = accessor(index);
    const std::size_t count = a["count"];
    const char* from = bytes_of(a);
    std::vector<unsigned> out(count);
    if (a["componentType"] != kShort) {
      std::memcpy(out.data(), from, count * sizeof(unsigned));
      return out;
    }
    std::vector<std::uint16_t> narrow(count);
    std::memcpy(narrow.data(), from, count * sizeof(std::uint16_t));
    out.assign(narrow.begin(), narrow.end());
    return out;
  }

  /// Appends bytes; the offset.
  std::size_t append(std::span<const char> data) {
    bytes_.resize((bytes_.size() + 7) / 8 * 8);
    const std::size_t offset = bytes_.size();
    bytes_.insert(bytes_.end(), data.begin(), data.end());
    return offset;
  }

  static draco::GeometryAttribute::Type kind(const std::string& name) {
    return name == "POSITION"        ? draco::GeometryAttribute::POSITION
           : name == "NORMAL"        ? draco::GeometryAttribute::NORMAL
           : name == "COLOR_0"       ? draco::GeometryAttribute::COLOR
           : name.starts_with("TEX") ? draco::GeometryAttribute::TEX_COORD
                                     : draco::GeometryAttribute::GENERIC;
  }

  void draco_primitive(Json* primitive) {
    const std::vector<unsigned> corners = indices((*primitive)["indices"]);
    draco::Mesh mesh;
    Json ids;
    for (const auto& [name, index] : (*primitive)["attributes"].items()) {
      const std::size_t width = components(accessor(index)), count = accessor(index)["count"];
      const std::vector<float> values = floats(index);
      mesh.set_num_points(static_cast<std::uint32_t>(count));
      draco::GeometryAttribute attribute;
      attribute.Init(kind(name), nullptr, static_cast<std::uint8_t>(width), draco::DT_FLOAT32, false,
                     static_cast<std::int64_t>(width * sizeof(float)), 0);
      const int id = mesh.AddAttribute(attribute, true, static_cast<std::uint32_t>(count));
      for (std::size_t v = 0; v < count; ++v)
        mesh.attribute(id)->SetAttributeValue(draco::AttributeValueIndex(static_cast<std::uint32_t>(v)),
                                              &values[v * width]);
      ids[name] = mesh.attribute(id)->unique_id();
      accessor(index).erase("bufferView");
    }
    for (std::size_t i = 0; i < corners.size(); i += 3) {
      const auto point = [&](std::size_t k) { return draco::PointIndex(corners[i + k]); };
      mesh.AddFace({point(0), point(1), point(2)});
    }
    draco::Encoder encoder;
    encoder.SetEncodingMethod(draco::MESH_SEQUENTIAL_ENCODING);
    draco::EncoderBuffer buffer;
    if (!encoder.EncodeMeshToBuffer(mesh, &buffer).ok()) throw std::runtime_error("Draco cannot encode");
    const std::size_t offset = append({buffer.data(), buffer.size()});
    root_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", buffer.size()}});
    accessor((*primitive)["indices"]).erase("bufferView");
    (*primitive)["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", root_["bufferViews"].size() - 1},
                                                                {"attributes", ids}};
  }

  void replace_view(const Json& index, const std::vector<unsigned char>& stream, std::size_t count, std::size_t stride,
                    const char* mode) {
    const std::size_t offset = append({reinterpret_cast<const char*>(stream.data()), stream.size()});
    Json& view = root_["bufferViews"][accessor(index)["bufferView"].get<std::size_t>()];
    view = {{"buffer", 1}, {"byteOffset", fallback_bytes_}, {"byteLength", count * stride}};
    view["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},          {"byteOffset", offset},
                                                     {"count", count},       {"byteLength", stream.size()},
                                                     {"byteStride", stride}, {"mode", mode}};
    fallback_bytes_ += (count * stride + 3) / 4 * 4;
  }

  void meshopt_vertices(const Json& index) {
    const std::vector<float> values = floats(index);
    const std::size_t stride = components(accessor(index)) * sizeof(float), count = accessor(index)["count"];
    std::vector<unsigned char> out(meshopt_encodeVertexBufferBound(count, stride));
    out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), values.data(), count, stride));
    replace_view(index, out, count, stride, "ATTRIBUTES");
  }

  void meshopt_indices(const Json& index, std::size_t vertex_count) {
    const std::vector<unsigned> corners = indices(index);
    std::vector<unsigned char> out(meshopt_encodeIndexBufferBound(corners.size(), vertex_count));
    out.resize(meshopt_encodeIndexBuffer(out.data(), out.size(), corners.data(), corners.size()));
    replace_view(index, out, corners.size(), accessor(index)["componentType"] == kShort ? 2 : 4, "TRIANGLES");
  }

  Json root_;
  std::vector<char> bytes_;
  std::size_t fallback_bytes_ = 0;
};

}  // namespace

void compress_glb(const std::string& path, MeshCodec codec) {
  Compressor file(path);
  codec == MeshCodec::draco ? file.compress_by_draco() : file.compress_by_meshopt();
  file.write(path);
}

}  // namespace maquette::test
