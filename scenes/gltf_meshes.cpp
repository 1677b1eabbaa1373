#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <numeric>

#include "scenes/error.h"
#include "scenes/gltf_document.h"
#include "scenes/gltf_draco.h"

namespace maquette::gltf {
namespace {

constexpr const char* kRemedy = "the file is damaged; export it again";
constexpr const char* kDraco = "KHR_draco_mesh_compression";
/// Above this, squares of lengths exceed float's range.
constexpr float kMaxCoordinate_m = 1e12f;

/// Import of one primitive of one mesh.
struct Task {
  std::size_t mesh = 0, primitive = 0;
  std::size_t cost = 0;
  Primitive out;
  bool drawable = true;
  Warnings warnings;
  std::exception_ptr failure;
};

std::string name_of(const Task& task) {
  return element("meshes", task.mesh) + "." + element("primitives", task.primitive);
}

bool is_usable(const glm::vec3& p) {
  return std::abs(p.x) <= kMaxCoordinate_m && std::abs(p.y) <= kMaxCoordinate_m && std::abs(p.z) <= kMaxCoordinate_m;
}

template <int N>
std::vector<glm::vec<N, float>> to_vectors(const DracoAttribute& attribute, const std::string& where) {
  if (attribute.components != N)
    throw Error(
        where,
        "has " + std::to_string(attribute.components) + " components in its Draco data, expected " + std::to_string(N),
        kRemedy);
  std::vector<glm::vec<N, float>> out(attribute.values.size() / N);
  for (std::size_t i = 0; i < out.size(); ++i)
    for (int c = 0; c < N; ++c) out[i][c] = attribute.values[i * N + static_cast<std::size_t>(c)];
  return out;
}

std::vector<glm::vec4> to_colors(const DracoAttribute& attribute, const std::string& where) {
  if (attribute.components == 4) return to_vectors<4>(attribute, where);
  std::vector<glm::vec4> out;
  for (const glm::vec3& rgb : to_vectors<3>(attribute, where)) out.emplace_back(rgb, 1.0f);
  return out;
}

/// Reads attributes of one primitive from its accessors or its Draco stream.
class AttributeReader {
 public:
  AttributeReader(const Document& document, const Task& task)
      : document_(document),
        where_(at(document.path, name_of(task))),
        json_(element_json(document, "meshes", task.mesh)["primitives"][task.primitive]) {
    const Json* compressed = find_extension(json_, kDraco);
    if (compressed == nullptr) return;
    std::map<std::string, std::uint32_t> ids;
    for (auto it = (*compressed)["attributes"].begin(); it != (*compressed)["attributes"].end(); ++it)
      ids[it.key()] = it.value().get<std::uint32_t>();
    draco_ = decode_draco(where_, view_bytes(document, (*compressed)["bufferView"].get<std::size_t>()), ids);
    compressed_ = true;
  }

  const Json& json() const { return json_; }
  const std::string& where() const { return where_; }
  bool has(const char* name) const { return json_["attributes"].contains(name); }

  template <int N>
  std::vector<glm::vec<N, float>> read(const char* name) const {
    if (!has(name)) return {};
    if (const auto found = draco_.attributes.find(name); found != draco_.attributes.end())
      return to_vectors<N>(found->second, where_ + "." + name);
    return read_vectors<N>(document_, json_["attributes"][name].get<std::size_t>());
  }

  std::vector<glm::vec4> read_colors(const char* name) const {
    if (!has(name)) return {};
    if (const auto found = draco_.attributes.find(name); found != draco_.attributes.end())
      return to_colors(found->second, where_ + "." + name);
    return gltf::read_colors(document_, json_["attributes"][name].get<std::size_t>());
  }

  std::vector<std::uint32_t> read_indices(std::size_t vertex_count) {
    if (compressed_) return std::move(draco_.indices);
    if (json_.contains("indices")) return gltf::read_indices(document_, json_["indices"].get<std::size_t>());
    std::vector<std::uint32_t> indices(vertex_count);
    std::iota(indices.begin(), indices.end(), 0u);
    return indices;
  }

 private:
  const Document& document_;
  std::string where_;
  const Json& json_;
  DracoMesh draco_;
  bool compressed_ = false;
};

std::vector<std::uint32_t> triangles_from_strip(const std::vector<std::uint32_t>& strip) {
  std::vector<std::uint32_t> out;
  for (std::size_t i = 2; i < strip.size(); ++i) {
    const bool odd = i % 2 == 1;
    out.insert(out.end(), {strip[i - 2], strip[odd ? i : i - 1], strip[odd ? i - 1 : i]});
  }
  return out;
}

std::vector<std::uint32_t> triangles_from_fan(const std::vector<std::uint32_t>& fan) {
  std::vector<std::uint32_t> out;
  for (std::size_t i = 2; i < fan.size(); ++i) out.insert(out.end(), {fan[i - 1], fan[i], fan[0]});
  return out;
}

void import_indices(AttributeReader* reader, Task* task) {
  const auto mode = reader->json().value("mode", std::size_t{TINYGLTF_MODE_TRIANGLES});
  std::vector<std::uint32_t> indices = reader->read_indices(task->out.positions.size());
  for (std::size_t i = 0; i < indices.size(); ++i)
    if (indices[i] >= task->out.positions.size())
      throw Error(reader->where(),
                  "index " + std::to_string(i) + " is vertex " + std::to_string(indices[i]) + " of " +
                      std::to_string(task->out.positions.size()),
                  kRemedy);
  if (find_extension(reader->json(), kDraco) != nullptr || mode == TINYGLTF_MODE_TRIANGLES) {
    task->out.indices = std::move(indices);
  } else if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
    task->out.indices = triangles_from_strip(indices);
  } else {
    task->out.indices = triangles_from_fan(indices);
  }
  if (task->out.indices.size() % 3 != 0) {
    task->warnings.add("indices are not a multiple of three: the incomplete triangle is dropped", name_of(*task));
    task->out.indices.resize(task->out.indices.size() / 3 * 3);
  }
}

void check_lengths(const AttributeReader& reader, const Primitive& primitive) {
  const auto check = [&](const char* name, std::size_t length) {
    if (length != 0 && length != primitive.positions.size())
      throw Error(
          reader.where() + "." + name,
          "has " + std::to_string(length) + " values for " + std::to_string(primitive.positions.size()) + " vertices",
          kRemedy);
  };
  check("NORMAL", primitive.normals.size());
  check("TANGENT", primitive.tangents.size());
  check("TEXCOORD_0", primitive.uvs[0].size());
  check("TEXCOORD_1", primitive.uvs[1].size());
  check("COLOR_0", primitive.colors.size());
}

template <typename Vector>
bool all_finite(const Vector& v) {
  for (int c = 0; c < v.length(); ++c)
    if (!std::isfinite(v[c])) return false;
  return true;
}

template <typename Vector>
std::size_t replace_non_finite(std::vector<Vector>* values, const Vector& by) {
  std::size_t count = 0;
  for (Vector& value : *values) {
    if (all_finite(value)) continue;
    value = by;
    ++count;
  }
  return count;
}

/// Removes triangles at vertices that are NaN, infinite or out of range, and moves those vertices to a valid one.
void repair_positions(Task* task) {
  Primitive& primitive = task->out;
  std::vector<char> bad(primitive.positions.size(), 0);
  std::size_t bad_count = 0;
  for (std::size_t i = 0; i < bad.size(); ++i)
    bad_count += static_cast<std::size_t>(bad[i] = !is_usable(primitive.positions[i]));
  if (bad_count == 0) return;
  task->warnings.add("positions are not finite or beyond 1e12 m: their triangles are dropped", name_of(*task));
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i + 2 < primitive.indices.size(); i += 3) {
    const std::uint32_t* t = &primitive.indices[i];
    if (!bad[t[0]] && !bad[t[1]] && !bad[t[2]]) kept.insert(kept.end(), t, t + 3);
  }
  primitive.indices = std::move(kept);
  const auto first_valid = std::find(bad.begin(), bad.end(), 0);
  if (first_valid == bad.end()) {
    task->drawable = false;
    return;
  }
  const glm::vec3 replacement = primitive.positions[static_cast<std::size_t>(first_valid - bad.begin())];
  for (std::size_t i = 0; i < bad.size(); ++i)
    if (bad[i]) primitive.positions[i] = replacement;
}

void repair(Task* task) {
  repair_positions(task);
  Primitive& primitive = task->out;
  std::size_t replaced = replace_non_finite(&primitive.normals, glm::vec3(0.0f));
  replaced += replace_non_finite(&primitive.tangents, glm::vec4(0.0f));
  for (auto& uvs : primitive.uvs) replaced += replace_non_finite(&uvs, glm::vec2(0.0f));
  replaced += replace_non_finite(&primitive.colors, glm::vec4(1.0f));
  if (replaced > 0) task->warnings.add("attributes that are not finite are replaced", name_of(*task));

  std::size_t degenerate = 0;
  for (std::size_t i = 0; i + 2 < primitive.indices.size(); i += 3) {
    const std::uint32_t* t = &primitive.indices[i];
    const glm::dvec3 a(primitive.positions[t[0]]), b(primitive.positions[t[1]]), c(primitive.positions[t[2]]);
    if (glm::cross(b - a, c - a) == glm::dvec3(0.0)) ++degenerate;
  }
  if (degenerate > 0) task->warnings.add("triangles of zero area are never seen", name_of(*task));
}

void warn_of_attributes(const AttributeReader& reader, Task* task) {
  for (auto it = reader.json()["attributes"].begin(); it != reader.json()["attributes"].end(); ++it) {
    const std::string& name = it.key();
    const bool is_read = name == "POSITION" || name == "NORMAL" || name == "TANGENT" || name == "TEXCOORD_0" ||
                         name == "TEXCOORD_1" || name == "COLOR_0";
    const bool of_skin = name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_");  // reported with the skins
    if (!is_read && !of_skin) task->warnings.add("the vertex attribute " + name + " is ignored", name_of(*task));
  }
  if (reader.json().contains("targets") && !reader.json()["targets"].empty())
    task->warnings.add("morph targets are ignored", name_of(*task));
}

void import_variants(const Document& document, const AttributeReader& reader, Primitive* primitive) {
  const Json* mapped = find_extension(reader.json(), "KHR_materials_variants");
  if (mapped == nullptr) return;
  const Json* declared = find_extension(document.root, "KHR_materials_variants");
  const std::size_t count = declared == nullptr ? 0 : (*declared)["variants"].size();
  for (const Json& mapping : (*mapped)["mappings"]) {
    if (!mapping.contains("variants")) continue;
    for (const Json& variant : mapping["variants"]) {
      const auto index = variant.get<std::size_t>();
      if (index >= count)
        throw Error(reader.where(), "names variant " + std::to_string(index) + " of " + std::to_string(count), kRemedy);
      primitive->variant_materials[static_cast<int>(index)] = mapping["material"].get<int>();
    }
  }
}

void import_primitive(const Document& document, Task* task) {
  const Json& json = element_json(document, "meshes", task->mesh)["primitives"][task->primitive];
  const auto mode = json.value("mode", std::size_t{TINYGLTF_MODE_TRIANGLES});
  if (mode > TINYGLTF_MODE_TRIANGLE_FAN)
    throw Error(at(document.path, name_of(*task)), "mode " + std::to_string(mode) + " is not one of glTF's", kRemedy);
  task->drawable = mode >= TINYGLTF_MODE_TRIANGLES;
  if (!task->drawable) {
    task->warnings.add("points and lines are not drawn", name_of(*task));
    return;
  }
  AttributeReader reader(document, *task);
  warn_of_attributes(reader, task);
  if (!reader.has("POSITION")) {
    task->warnings.add("has no POSITION and is not drawn", name_of(*task));
    task->drawable = false;
    return;
  }
  Primitive& out = task->out;
  out.positions = reader.read<3>("POSITION");
  out.normals = reader.read<3>("NORMAL");
  out.tangents = reader.read<4>("TANGENT");
  out.uvs[0] = reader.read<2>("TEXCOORD_0");
  out.uvs[1] = reader.read<2>("TEXCOORD_1");
  out.colors = reader.read_colors("COLOR_0");
  check_lengths(reader, out);
  import_indices(&reader, task);
  out.material = json.value("material", -1);
  import_variants(document, reader, &out);
  repair(task);
}

std::size_t estimate_cost(const Document& document, const Json& primitive) {
  if (const Json* compressed = find_extension(primitive, kDraco); compressed != nullptr)
    return 16 * document.model.bufferViews[(*compressed)["bufferView"].get<std::size_t>()].byteLength;
  const auto position = primitive["attributes"].find("POSITION");
  return position == primitive["attributes"].end() ? 0 : document.model.accessors[position->get<std::size_t>()].count;
}

/// Runs the most expensive tasks first, each on the next free thread, so that a large stream is not the last one.
void run_in_parallel(const Document& document, std::vector<Task>* tasks) {
  std::vector<std::size_t> order(tasks->size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return (*tasks)[a].cost > (*tasks)[b].cost; });
  std::atomic<std::size_t> next{0};
  tbb::parallel_for(std::size_t{0}, tasks->size(), [&](std::size_t) {
    Task& task = (*tasks)[order[next.fetch_add(1)]];
    try {
      import_primitive(document, &task);
    } catch (...) {
      task.failure = std::current_exception();
    }
  });
}

}  // namespace

void import_meshes(Document* document, Scene* scene) {
  const auto found = document->root.find("meshes");
  if (found == document->root.end()) return;
  std::vector<Task> tasks;
  for (std::size_t m = 0; m < found->size(); ++m) {
    scene->meshes.emplace_back().name = (*found)[m].value("name", "");
    for (std::size_t p = 0; p < (*found)[m]["primitives"].size(); ++p) {
      Task& task = tasks.emplace_back();
      task.mesh = m;
      task.primitive = p;
      task.cost = estimate_cost(*document, (*found)[m]["primitives"][p]);
    }
  }
  run_in_parallel(*document, &tasks);
  for (Task& task : tasks) {
    if (task.failure) std::rethrow_exception(task.failure);
    document->warnings.merge(task.warnings);
    if (task.drawable) scene->meshes[task.mesh].primitives.push_back(std::move(task.out));
  }
}

}  // namespace maquette::gltf
