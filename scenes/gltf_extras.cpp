#include <algorithm>
#include <cmath>
#include <optional>

#include "scenes/error.h"
#include "scenes/gltf_document.h"
#include "scenes/subdivision.h"
#include "scenes/subdivision_cage.h"

namespace maquette::gltf {
namespace {

constexpr const char* kSeeFormats = "see docs/formats.md for the members of extras.maquette";

/// Reads numbers that are given directly or by the index of an accessor.
class ArrayReader {
 public:
  ArrayReader(const Document& document, const Json& object, std::string where)
      : document_(document), object_(object), where_(std::move(where)) {}

  template <int N>
  std::vector<glm::vec<N, float>> vectors(const char* key) const {
    if (const auto accessor = accessor_of(key)) return read_vectors<N>(document_, *accessor);
    const std::vector<double> flat = numbers(key);
    if (flat.size() % N != 0)
      fail(key, "has " + std::to_string(flat.size()) + " numbers, not a multiple of " + std::to_string(N));
    std::vector<glm::vec<N, float>> out(flat.size() / N);
    for (std::size_t i = 0; i < flat.size(); ++i)
      out[i / N][static_cast<glm::length_t>(i % N)] = static_cast<float>(flat[i]);
    return out;
  }

  std::vector<float> scalars(const char* key) const {
    if (const auto accessor = accessor_of(key)) return read_scalars(document_, *accessor);
    const std::vector<double> flat = numbers(key);
    return {flat.begin(), flat.end()};
  }

  std::vector<int> naturals(const char* key) const {
    std::vector<int> out;
    if (const auto accessor = accessor_of(key)) {
      for (const std::uint32_t value : read_indices(document_, *accessor))
        out.push_back(static_cast<int>(value & 0x7fffffffu));
      return out;
    }
    for (const double value : numbers(key)) {
      if (!(value >= 0.0 && value < 2147483648.0 && value == std::floor(value)))
        fail(key, "holds a number that is no index");
      out.push_back(static_cast<int>(value));
    }
    return out;
  }

  [[noreturn]] void fail(const char* key, const std::string& what) const {
    throw Error(where_ + "." + key, what, kSeeFormats);
  }

 private:
  std::optional<std::size_t> accessor_of(const char* key) const {
    const auto found = object_.find(key);
    if (found == object_.end() || !found->is_number()) return std::nullopt;
    if (!found->is_number_unsigned() || found->get<std::size_t>() >= document_.model.accessors.size())
      fail(key, "names an accessor that is not there");
    return found->get<std::size_t>();
  }

  std::vector<double> numbers(const char* key) const {
    std::vector<double> out;
    const auto found = object_.find(key);
    if (found == object_.end()) return out;
    if (!found->is_array()) fail(key, "is neither an array of numbers nor the index of an accessor");
    for (const Json& value : *found) {
      if (!value.is_number()) fail(key, "holds something else than numbers");
      out.push_back(value.get<double>());
    }
    return out;
  }

  const Document& document_;
  const Json& object_;
  std::string where_;
};

SubdivisionCage read_cage(const Document& document, const Json& json, const std::string& where) {
  const ArrayReader reader(document, json, where);
  SubdivisionCage cage;
  cage.positions = reader.vectors<3>("positions");
  cage.uvs = reader.vectors<2>("uvs");
  cage.face_sizes = reader.naturals("face_sizes");
  cage.face_indices = reader.naturals("face_indices");
  const std::vector<int> ends = reader.naturals("crease_edges");
  if (ends.size() % 2 != 0) reader.fail("crease_edges", "does not hold pairs");
  for (std::size_t i = 0; i < ends.size(); i += 2) cage.crease_edges.push_back({ends[i], ends[i + 1]});
  cage.crease_sharpness = reader.scalars("crease_sharpness");
  cage.levels = static_cast<int>(std::min<std::size_t>(read_natural(json, "levels", 2, where), 1000));
  return cage;
}

void import_cage(const Document& document, const Json& json, const std::string& where, Mesh* mesh) {
  if (!json.is_object()) throw Error(where, "expected an object", kSeeFormats);
  SubdivisionCage cage = read_cage(document, json, where);
  try {
    check_cage(cage);
    const std::size_t stored = mesh->primitives.empty() ? 0 : mesh->primitives[0].positions.size();
    const bool current = stored > 0 && stored == read_natural(json, "vertex_count", 0, where) &&
                         mesh->primitives[0].indices.size() == count_limit_indices(cage);
    mesh->cage = std::make_shared<const SubdivisionCage>(std::move(cage));
    if (!current) tessellate_cage(mesh);
  } catch (const Error& e) {
    throw Error(where, e.what());
  }
}

}  // namespace

void import_cages(const Document& document, Scene* scene) {
  constexpr std::size_t kMostIndices = std::size_t{6} << 21;  // of all: each is as large as its levels say
  std::size_t indices = 0;
  for (std::size_t i = 0; i < scene->meshes.size(); ++i) {
    const Json* extras = find_extras(element_json(document, "meshes", document.mesh_uses[i].mesh));
    if (extras == nullptr || !extras->contains("subdivision")) continue;
    const std::string where =
        at(document.path, element("meshes", document.mesh_uses[i].mesh) + ".extras.maquette.subdivision");
    import_cage(document, (*extras)["subdivision"], where, &scene->meshes[i]);
    indices += scene->meshes[i].primitives.front().indices.size();
    if (indices > kMostIndices)
      throw Error(where, "brings the cages of the file to more than two million quads", "take fewer levels");
  }
}

void import_patches(const Document& document, Scene* scene) {
  const Json* extras = find_extras(document.root);
  if (extras == nullptr || !extras->contains("bezier_patches")) return;
  const std::string list = at(document.path, "extras.maquette.bezier_patches");
  const Json& patches = (*extras)["bezier_patches"];
  if (!patches.is_array()) throw Error(list, "expected an array", kSeeFormats);
  for (std::size_t i = 0; i < patches.size(); ++i) {
    const std::string where = list + "[" + std::to_string(i) + "]";
    if (!patches[i].is_object()) throw Error(where, "expected an object", kSeeFormats);
    const std::vector<glm::vec3> points = ArrayReader(document, patches[i], where).vectors<3>("points");
    BezierPatch patch;
    if (points.size() != patch.points.size())
      throw Error(where + ".points", "has " + std::to_string(points.size()) + " points, expected 16", kSeeFormats);
    for (const glm::vec3& p : points)
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
        throw Error(where + ".points", "are not finite", kSeeFormats);
    std::copy(points.begin(), points.end(), patch.points.begin());
    patch.name = read_text(patches[i], "name", where);
    patch.reflector = read_flag(patches[i], "reflector", true, where);
    if (patches[i].contains("material")) {
      const std::size_t material = read_natural(patches[i], "material", 0, where);
      if (material >= scene->materials.size()) throw Error(where + ".material", "is out of range", kSeeFormats);
      patch.material = static_cast<int>(material);
    }
    scene->patches.push_back(patch);
  }
}

void import_node_extras(const Json& json, const std::string& where, const Scene& scene, Node* node) {
  const Json* extras = find_extras(json);
  if (extras == nullptr) return;
  const std::string extras_path = where + ".extras.maquette";
  node->reflector = read_flag(*extras, "reflector", false, extras_path);
  node->visible = read_flag(*extras, "visible", true, extras_path);
  if (!extras->contains("bezier_patch")) return;
  const std::size_t patch = read_natural(*extras, "bezier_patch", 0, extras_path);
  if (patch >= scene.patches.size()) throw Error(extras_path + ".bezier_patch", "is out of range", kSeeFormats);
  node->patch = static_cast<int>(patch);
}

}  // namespace maquette::gltf
