#include <stb/stb_image_write.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <glm/gtc/type_ptr.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/gltf_materials_save.h"
#include "scenes/scene.h"

namespace maquette {
namespace {

using Json = nlohmann::json;

constexpr int kShort = 5123, kUnsigned = 5125, kFloat = 5126;
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
constexpr std::uint32_t kGlbMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;

template <typename Vector>
Json to_json(const Vector& v, int count) {
  Json out = Json::array();
  for (int i = 0; i < count; ++i) out.push_back(glm::value_ptr(v)[i]);
  return out;
}

/// Builds the JSON and the binary chunk of one scene.
class GlbWriter {
 public:
  GlbWriter(const std::string& path, const Scene& scene) : path_(path), scene_(scene) {
    root_["asset"] = {{"version", "2.0"}, {"generator", "maquette"}};
  }

  std::vector<std::byte> write() {
    write_images();
    for (Json& material : materials_to_json(scene_, path_, &root_, &extensions_))
      root_["materials"].push_back(std::move(material));
    for (const Mesh& mesh : scene_.meshes) root_["meshes"].push_back(mesh_to_json(mesh));
    write_cameras();
    write_lights();
    write_variants();
    write_patches();
    write_nodes();
    write_animations();
    for (const std::string& extension : extensions_) root_["extensionsUsed"].push_back(extension);
    if (!binary_.empty()) root_["buffers"] = {{{"byteLength", binary_.size()}}};
    return assemble();
  }

 private:
  void align() { binary_.resize((binary_.size() + 3) / 4 * 4); }

  int add_view(const void* data, std::size_t size, int target) {
    align();
    Json view = {{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", size}};
    if (target != 0) view["target"] = target;
    root_["bufferViews"].push_back(std::move(view));
    const auto* bytes = static_cast<const std::byte*>(data);
    binary_.insert(binary_.end(), bytes, bytes + size);
    return static_cast<int>(root_["bufferViews"].size()) - 1;
  }

  int add_accessor(const void* data, std::size_t count, std::size_t element_bytes, int component_type, const char* type,
                   int target) {
    Json accessor = {{"componentType", component_type}, {"count", count}, {"type", type}};
    if (count > 0) accessor["bufferView"] = add_view(data, count * element_bytes, target);
    root_["accessors"].push_back(std::move(accessor));
    return static_cast<int>(root_["accessors"].size()) - 1;
  }

  template <typename T>
  int add_floats(const std::vector<T>& values, const char* type, int target = kArrayBuffer) {
    return add_accessor(values.data(), values.size(), sizeof(T), kFloat, type, target);
  }

  int add_integers(const std::vector<std::uint32_t>& values, std::size_t end, int target) {
    if (end > std::numeric_limits<std::uint16_t>::max())
      return add_accessor(values.data(), values.size(), sizeof(std::uint32_t), kUnsigned, "SCALAR", target);
    std::vector<std::uint16_t> narrow;
    for (const std::uint32_t value : values) narrow.push_back(static_cast<std::uint16_t>(value));
    return add_accessor(narrow.data(), narrow.size(), sizeof(std::uint16_t), kShort, "SCALAR", target);
  }

  int add_naturals(const std::vector<int>& values) {
    const std::vector<std::uint32_t> unsigned_values(values.begin(), values.end());
    const auto largest = std::max_element(unsigned_values.begin(), unsigned_values.end());
    return add_integers(unsigned_values, largest == unsigned_values.end() ? 0 : *largest, 0);
  }

  int add_positions(const std::vector<glm::vec3>& positions) {
    const int index = add_floats(positions, "VEC3");
    glm::vec3 low(0.0f), high(0.0f);
    for (std::size_t i = 0; i < positions.size(); ++i) {
      low = i == 0 ? positions[i] : glm::min(low, positions[i]);
      high = i == 0 ? positions[i] : glm::max(high, positions[i]);
    }
    root_["accessors"].back()["min"] = to_json(low, 3);
    root_["accessors"].back()["max"] = to_json(high, 3);
    return index;
  }

  Json primitive_to_json(const Primitive& primitive) {
    Json out;
    Json& attributes = out["attributes"];
    attributes["POSITION"] = add_positions(primitive.positions);
    if (!primitive.normals.empty()) attributes["NORMAL"] = add_floats(primitive.normals, "VEC3");
    if (!primitive.tangents.empty()) attributes["TANGENT"] = add_floats(primitive.tangents, "VEC4");
    if (!primitive.uvs[0].empty()) attributes["TEXCOORD_0"] = add_floats(primitive.uvs[0], "VEC2");
    if (!primitive.uvs[1].empty()) attributes["TEXCOORD_1"] = add_floats(primitive.uvs[1], "VEC2");
    if (!primitive.colors.empty()) attributes["COLOR_0"] = add_floats(primitive.colors, "VEC4");
    out["indices"] = add_integers(primitive.indices, primitive.positions.size(), kElementArrayBuffer);
    if (primitive.material >= 0) out["material"] = primitive.material;
    if (!primitive.variant_materials.empty()) {
      extensions_.insert("KHR_materials_variants");
      Json mappings = Json::array();
      for (const auto& [variant, material] : primitive.variant_materials)
        mappings.push_back({{"material", material}, {"variants", {variant}}});
      out["extensions"]["KHR_materials_variants"]["mappings"] = std::move(mappings);
    }
    return out;
  }

  Json cage_to_json(const SubdivisionCage& cage, const Mesh& mesh) {
    Json out = {{"levels", cage.levels}};
    out["positions"] = add_floats(cage.positions, "VEC3", 0);
    if (!cage.uvs.empty()) out["uvs"] = add_floats(cage.uvs, "VEC2", 0);
    out["face_sizes"] = add_naturals(cage.face_sizes);
    out["face_indices"] = add_naturals(cage.face_indices);
    if (!cage.crease_edges.empty()) {
      std::vector<int> ends;
      for (const auto& [a, b] : cage.crease_edges) ends.insert(ends.end(), {a, b});
      out["crease_edges"] = add_naturals(ends);
      out["crease_sharpness"] = add_floats(cage.crease_sharpness, "SCALAR", 0);
    }
    if (!mesh.primitives.empty()) out["vertex_count"] = mesh.primitives[0].positions.size();
    return out;
  }

  Json mesh_to_json(const Mesh& mesh) {
    Json out = {{"primitives", Json::array()}};
    if (!mesh.name.empty()) out["name"] = mesh.name;
    for (const Primitive& primitive : mesh.primitives) out["primitives"].push_back(primitive_to_json(primitive));
    if (mesh.cage) out["extras"]["maquette"]["subdivision"] = cage_to_json(*mesh.cage, mesh);
    return out;
  }

  void write_images() {
    for (const TextureImage& image : scene_.images) {
      std::vector<std::byte> png;
      const auto append = [](void* context, void* data, int size) {
        auto* out = static_cast<std::vector<std::byte>*>(context);
        const auto* bytes = static_cast<const std::byte*>(data);
        out->insert(out->end(), bytes, bytes + size);
      };
      // No texture shows an image that was left out: one texel keeps the numbers of the others.
      const bool empty = image.width == 0;
      const std::vector<std::uint8_t> texel(4, 0);
      const int width = empty ? 1 : image.width, height = empty ? 1 : image.height;
      const std::uint8_t* texels = empty ? texel.data() : image.rgba.data();
      if (stbi_write_png_to_func(append, &png, width, height, 4, texels, 4 * width) == 0)
        throw Error(path_, "image \"" + image.name + "\" cannot be written as PNG");
      Json out = {{"mimeType", "image/png"}, {"bufferView", add_view(png.data(), png.size(), 0)}};
      if (!image.name.empty()) out["name"] = image.name;
      root_["images"].push_back(std::move(out));
    }
  }

  void write_cameras() {
    for (const Camera& camera : scene_.cameras) {
      const bool parallel = camera.height_m > 0.0f;
      Json lens = {{"znear", camera.near_m}};
      if (std::isfinite(camera.far_m)) lens["zfar"] = camera.far_m;
      if (parallel) {
        lens["ymag"] = 0.5f * camera.height_m;
        lens["xmag"] = 0.5f * camera.height_m * (camera.aspect > 0.0f ? camera.aspect : 1.0f);
      } else {
        lens["yfov"] = camera.fov_y_rad;
        if (camera.aspect > 0.0f) lens["aspectRatio"] = camera.aspect;
      }
      const char* type = parallel ? "orthographic" : "perspective";
      root_["cameras"].push_back({{"name", camera.name}, {"type", type}, {type, std::move(lens)}});
    }
  }

  void write_lights() {
    for (const PunctualLight& light : scene_.lights) {
      Json out = {{"color", to_json(light.color, 3)}, {"intensity", light.intensity}};
      if (!light.name.empty()) out["name"] = light.name;
      if (light.range_m > 0.0f) out["range"] = light.range_m;
      out["type"] = light.kind == PunctualLight::Kind::directional ? "directional"
                    : light.kind == PunctualLight::Kind::point     ? "point"
                                                                   : "spot";
      if (light.kind == PunctualLight::Kind::spot)
        out["spot"] = {{"innerConeAngle", light.inner_cone_rad}, {"outerConeAngle", light.outer_cone_rad}};
      extensions_.insert("KHR_lights_punctual");
      root_["extensions"]["KHR_lights_punctual"]["lights"].push_back(std::move(out));
    }
  }

  void write_variants() {
    for (const std::string& name : scene_.variants) {
      extensions_.insert("KHR_materials_variants");
      root_["extensions"]["KHR_materials_variants"]["variants"].push_back({{"name", name}});
    }
  }

  void write_patches() {
    for (const BezierPatch& patch : scene_.patches) {
      Json points = Json::array();
      for (const glm::vec3& point : patch.points)
        for (int c = 0; c < 3; ++c) points.push_back(point[c]);
      Json out = {{"points", std::move(points)}, {"reflector", patch.reflector}};
      if (!patch.name.empty()) out["name"] = patch.name;
      if (patch.material >= 0) out["material"] = patch.material;
      root_["extras"]["maquette"]["bezier_patches"].push_back(std::move(out));
    }
  }

  void write_nodes() {
    for (const Node& node : scene_.nodes) {
      Json out = Json::object();
      if (!node.name.empty()) out["name"] = node.name;
      if (!node.children.empty()) out["children"] = node.children;
      if (node.local != glm::mat4(1.0f)) out["matrix"] = to_json(node.local, 16);
      if (node.mesh >= 0) out["mesh"] = node.mesh;
      if (node.camera >= 0) out["camera"] = node.camera;
      if (node.light >= 0) out["extensions"]["KHR_lights_punctual"]["light"] = node.light;
      if (node.patch >= 0) out["extras"]["maquette"]["bezier_patch"] = node.patch;
      if (node.reflector) out["extras"]["maquette"]["reflector"] = true;
      if (!node.visible) out["extras"]["maquette"]["visible"] = false;
      root_["nodes"].push_back(std::move(out));
    }
    root_["scene"] = 0;
    root_["scenes"].push_back(Json::object());
    if (!scene_.roots.empty()) root_["scenes"][0]["nodes"] = scene_.roots;
  }

  /// Channels move translation, rotation and scale: the nodes have these in place of their matrices.
  void write_animations() {
    static constexpr const char* kPaths[] = {"translation", "rotation", "scale"};
    static constexpr const char* kInterpolations[] = {"STEP", "LINEAR", "CUBICSPLINE"};
    for (const Animation& animation : scene_.animations) {
      Json out = {{"name", animation.name}, {"channels", Json::array()}, {"samplers", Json::array()}};
      for (const AnimatedNode& node : animation.nodes) {
        Json& moved = root_["nodes"][static_cast<std::size_t>(node.node)];
        moved.erase("matrix");
        for (std::size_t i = 0; i < AnimatedNode::kProperties; ++i) {
          const bool rotation = i == AnimatedNode::rotation;
          moved[kPaths[i]] = to_json(node.rest[i], rotation ? 4 : 3);
          const AnimationTrack& track = node.tracks[i];
          if (track.times_s.empty()) continue;
          const std::vector<glm::vec3> vectors(track.values.begin(), track.values.end());
          const int output = rotation ? add_floats(track.values, "VEC4", 0) : add_floats(vectors, "VEC3", 0);
          out["channels"].push_back(
              {{"sampler", out["samplers"].size()}, {"target", {{"node", node.node}, {"path", kPaths[i]}}}});
          out["samplers"].push_back({{"input", add_floats(track.times_s, "SCALAR", 0)},
                                     {"output", output},
                                     {"interpolation", kInterpolations[static_cast<int>(track.interpolation)]}});
        }
      }
      root_["animations"].push_back(std::move(out));
    }
  }

  std::vector<std::byte> assemble() {
    std::string json = root_.dump();
    json.resize((json.size() + 3) / 4 * 4, ' ');
    align();
    const std::size_t size = 12 + 8 + json.size() + (binary_.empty() ? 0 : 8 + binary_.size());
    if (size > std::numeric_limits<std::uint32_t>::max())
      throw Error(path_, "the scene is larger than the 4 GB of a GLB");
    std::vector<std::byte> file;
    file.reserve(size);
    const auto put = [&file](const void* data, std::size_t count) {
      const auto* bytes = static_cast<const std::byte*>(data);
      file.insert(file.end(), bytes, bytes + count);
    };
    const auto put_pair = [&put](std::uint32_t a, std::uint32_t b) {
      const std::uint32_t pair[2] = {a, b};
      put(pair, sizeof(pair));
    };
    put(&kGlbMagic, sizeof(kGlbMagic));
    put_pair(2, static_cast<std::uint32_t>(size));
    put_pair(static_cast<std::uint32_t>(json.size()), kJsonChunk);
    put(json.data(), json.size());
    if (binary_.empty()) return file;
    put_pair(static_cast<std::uint32_t>(binary_.size()), kBinaryChunk);
    put(binary_.data(), binary_.size());
    return file;
  }

  const std::string& path_;
  const Scene& scene_;
  Json root_;
  std::vector<std::byte> binary_;
  std::set<std::string> extensions_;
};

}  // namespace

void save_glb(const std::string& path, const Scene& scene) {
  const std::vector<std::byte> file = GlbWriter(path, scene).write();
  write_file_atomically(path, file);
}

}  // namespace maquette
