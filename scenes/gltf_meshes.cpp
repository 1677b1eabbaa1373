
#include <algorithm>
#include <atomic>
#include <exception>
#include <numeric>
#include <set>
#include <utility>

#include "scenes/error.h"
#include "scenes/gltf_primitive.h"
#include "scenes/parallel.h"

namespace maquette::gltf {
namespace {

/// An exception of a task is thrown again when all are done, the one of the first task.
struct Task : PrimitiveTask {
  std::size_t target = 0;  ///< mesh of the scene
  std::exception_ptr failure;
};

constexpr const char* kDracoCompression = "KHR_draco_mesh_compression";

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

void import_indices(AttributeReader* reader, PrimitiveTask* task) {
  const auto mode = reader->json().value("mode", std::size_t{TINYGLTF_MODE_TRIANGLES});
  std::vector<std::uint32_t> indices = reader->read_indices(task->out.positions.size());
  for (std::size_t i = 0; i < indices.size(); ++i)
    if (indices[i] >= task->out.positions.size())
      throw Error(reader->where(),
                  "index " + std::to_string(i) + " is vertex " + std::to_string(indices[i]) + " of " +
                      std::to_string(task->out.positions.size()),
                  kDamaged);
  if (find_extension(reader->json(), kDracoCompression) != nullptr || mode == TINYGLTF_MODE_TRIANGLES) {
    task->out.indices = std::move(indices);
  } else if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
    task->out.indices = triangles_from_strip(indices);
  } else {
    task->out.indices = triangles_from_fan(indices);
  }
  if (task->out.indices.size() % 3 != 0) {
    task->warnings.add("indices are not a multiple of three: the incomplete triangle is dropped", task->name());
    task->out.indices.resize(task->out.indices.size() / 3 * 3);
  }
}

void check_lengths(const AttributeReader& reader, const Primitive& primitive) {
  const auto check = [&](const char* name, std::size_t length) {
    if (length != 0 && length != primitive.positions.size())
      throw Error(
          reader.where() + "." + name,
          "has " + std::to_string(length) + " values for " + std::to_string(primitive.positions.size()) + " vertices",
          kDamaged);
  };
  check("NORMAL", primitive.normals.size());
  check("TANGENT", primitive.tangents.size());
  check("TEXCOORD_0", primitive.uvs[0].size());
  check("TEXCOORD_1", primitive.uvs[1].size());
  check("COLOR_0", primitive.colors.size());
}

void warn_of_attributes(const AttributeReader& reader, PrimitiveTask* task) {
  for (auto it = reader.json()["attributes"].begin(); it != reader.json()["attributes"].end(); ++it) {
    const std::string& name = it.key();
    const bool is_read = name == "POSITION" || name == "NORMAL" || name == "TANGENT" || name == "TEXCOORD_0" ||
                         name == "TEXCOORD_1" || name == "COLOR_0";
    const bool of_skin = name.starts_with("JOINTS_") || name.starts_with("WEIGHTS_");
    if (!is_read && !of_skin) task->warnings.add("the vertex attribute " + name + " is ignored", task->name());
  }
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
        throw Error(reader.where(), "names variant " + std::to_string(index) + " of " + std::to_string(count),
                    kDamaged);
      primitive->variant_materials[static_cast<int>(index)] = mapping["material"].get<int>();
    }
  }
}

/// Whether any of its accessors does.
bool primitive_lacks_bytes(const Document& document, const Json& primitive) {
  if (find_extension(primitive, kDracoCompression) != nullptr) return false;
  std::vector<std::size_t> accessors;
  for (const auto& [name, accessor] : primitive["attributes"].items()) accessors.push_back(accessor.get<std::size_t>());
  if (primitive.contains("indices")) accessors.push_back(primitive["indices"].get<std::size_t>());
  return std::any_of(accessors.begin(), accessors.end(),
                     [&](std::size_t accessor) { return lacks_bytes(document, accessor); });
}

void import_primitive(const Document& document, PrimitiveTask* task) {
  const Json& json = element_json(document, "meshes", task->mesh)["primitives"][task->primitive];
  const auto mode = json.value("mode", std::size_t{TINYGLTF_MODE_TRIANGLES});
  if (mode > TINYGLTF_MODE_TRIANGLE_FAN)
    throw Error(at(document.path, task->name()), "mode " + std::to_string(mode) + " is not one of glTF's", kDamaged);
  task->drawable = mode >= TINYGLTF_MODE_TRIANGLES;
  if (!task->drawable) {
    task->warnings.add("points and lines are not drawn", task->name());
    return;
  }
  AttributeReader reader(document, task);
  warn_of_attributes(reader, task);
  if (!reader.has("POSITION")) {
    task->warnings.add("has no POSITION and is not drawn", task->name());
    task->drawable = false;
    return;
  }
  if (primitive_lacks_bytes(document, json)) {
    task->warnings.add("is made of a buffer that has no uri, so that its bytes are nowhere, and is not drawn",
                       task->name());
    task->drawable = false;
    return;
  }
  Primitive& out = task->out;
  out.positions = reader.read<3>("POSITION");
  out.normals = reader.read<3>("NORMAL");
  out.tangents = reader.read_tangents();
  out.uvs[0] = reader.read<2>("TEXCOORD_0");
  out.uvs[1] = reader.read<2>("TEXCOORD_1");
  out.colors = reader.read_colors();
  check_lengths(reader, out);
  import_indices(&reader, task);
  out.material = json.value("material", -1);
  import_variants(document, reader, &out);
  apply_skin(reader, task);
  repair_primitive(task);
  if (!reader.has("NORMAL")) add_flat_normals(&out);
}

std::size_t estimate_cost(const Document& document, const Json& primitive) {
  if (const Json* compressed = find_extension(primitive, kDracoCompression); compressed != nullptr)
    return 16 * document.model.bufferViews[(*compressed)["bufferView"].get<std::size_t>()].byteLength;
  const auto position = primitive["attributes"].find("POSITION");
  return position == primitive["attributes"].end() ? 0 : document.model.accessors[position->get<std::size_t>()].count;
}

/// Elements that meshes read once more: of accessors that several primitives share, and of meshes in several poses. A
/// file says in a few bytes that it wants them again and again.
void check_repeated(const Document& document) {
  constexpr std::size_t kMostRepeated = 20'000'000;
  std::set<std::size_t> read;
  std::size_t repeated = 0;
  const auto count = [&](const Json& accessor) {
    const auto index = accessor.get<std::size_t>();
    if (!read.insert(index).second) repeated += document.model.accessors[index].count;
  };
  for (const MeshUse& use : document.mesh_uses)
    for (const Json& primitive : element_json(document, "meshes", use.mesh)["primitives"]) {
      if (const auto found = primitive["attributes"].find("POSITION"); found != primitive["attributes"].end())
        count(*found);
      if (const auto found = primitive.find("indices"); found != primitive.end()) count(*found);
      if (const auto found = primitive.find("targets"); found != primitive.end())
        for (const Json& target : *found)
          for (const Json& accessor : target)
            if (accessor.is_number_unsigned() && accessor.get<std::size_t>() < document.model.accessors.size())
              count(accessor);
    }
  if (repeated > kMostRepeated)
    throw Error(document.path,
                "its meshes read " + std::to_string(repeated) + " elements of accessors again, at most " +
                    std::to_string(kMostRepeated) + " are possible",
                "let nodes share meshes instead");
}

/// Runs the most expensive tasks first, each on the next free thread, so that a large stream is not the last one.
void run_in_parallel(const Document& document, std::vector<Task>* tasks) {
  std::vector<std::size_t> order(tasks->size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return (*tasks)[a].cost > (*tasks)[b].cost; });
  std::atomic<std::size_t> next{0};
  parallel_for(std::size_t{0}, tasks->size(), [&](std::size_t) {
    Task& task = (*tasks)[order[next.fetch_add(1)]];
    try {
      import_primitive(document, &task);
    } catch (...) {
      task.failure = std::current_exception();
    }
  });
}

/// UV sets that a material's textures read, as bits.
unsigned sets_of(const Material& material) {
  unsigned sets = 0;
  for (const auto texture : kMaterialTextures)
    if (material.*texture) sets |= 1u << (material.*texture).uv_set;
  return sets;
}

/// A texture without its coordinates shows one texel all over.
void warn_of_missing_coordinates(const Scene& scene, const Primitive& primitive, const Task& task, Warnings* warnings) {
  unsigned sets = 0;
  const auto add = [&](int material) {
    if (material >= 0) sets |= sets_of(scene.materials.at(static_cast<std::size_t>(material)));
  };
  add(primitive.material);
  for (const auto& [variant, material] : primitive.variant_materials) add(material);
  for (std::size_t set = 0; set < primitive.uvs.size(); ++set)
    if ((sets >> set & 1u) != 0 && primitive.uvs[set].empty())
      warnings->add("its textures use TEXCOORD_" + std::to_string(set) + ", which it does not have: taken as (0, 0)",
                    task.name());
}

}  // namespace

void import_meshes(Document* document, Scene* scene) {
  check_repeated(*document);
  std::vector<Task> tasks;
  for (std::size_t m = 0; m < document->mesh_uses.size(); ++m) {
    const MeshUse& use = document->mesh_uses[m];
    const Json& mesh = element_json(*document, "meshes", use.mesh);
    scene->meshes.emplace_back().name = mesh.value("name", "");
    for (std::size_t p = 0; p < mesh["primitives"].size(); ++p) {
      Task& task = tasks.emplace_back();
      task.mesh = use.mesh;
      task.target = m;
      task.primitive = p;
      task.use = &use;
      task.cost = estimate_cost(*document, mesh["primitives"][p]);
    }
  }
  run_in_parallel(*document, &tasks);
  std::set<std::pair<std::size_t, std::size_t>> warned;
  for (Task& task : tasks) {
    if (task.failure) std::rethrow_exception(task.failure);
    // Each use of a mesh finds the same faults.
    if (warned.insert({task.mesh, task.primitive}).second) {
      if (task.drawable) warn_of_missing_coordinates(*scene, task.out, task, &task.warnings);
      document->warnings.merge(task.warnings);
    }
    if (task.drawable) scene->meshes[task.target].primitives.push_back(std::move(task.out));
  }
}

}  // namespace maquette::gltf
