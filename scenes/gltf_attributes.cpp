#include <algorithm>
#include <limits>
#include <numeric>

#include "scenes/error.h"
#include "scenes/gltf_primitive.h"

namespace maquette::gltf {
namespace {

constexpr const char* kDraco = "KHR_draco_mesh_compression";

/// Largest value of glTF's integer types; 0 for float.
float largest_of(int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return std::numeric_limits<std::int8_t>::max();
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return std::numeric_limits<std::uint8_t>::max();
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return std::numeric_limits<std::int16_t>::max();
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return std::numeric_limits<std::uint16_t>::max();
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return static_cast<float>(std::numeric_limits<std::uint32_t>::max());
    default:
      return 0.0f;
  }
}

/// What the decoded integers mean says the accessor; where it speaks of floats, the stream does.
float divisor_of(const DracoAttribute& attribute, const tinygltf::Accessor& accessor) {
  if (attribute.integer_max == 0.0f) return 1.0f;
  const float largest = largest_of(accessor.componentType);
  if (largest > 0.0f) return accessor.normalized ? largest : 1.0f;
  return attribute.normalized ? attribute.integer_max : 1.0f;
}

template <int N>
std::vector<glm::vec<N, float>> to_vectors(const DracoAttribute& attribute, float divisor, const std::string& where) {
  if (attribute.components != N)
    throw Error(
        where,
        "has " + std::to_string(attribute.components) + " components in its Draco data, expected " + std::to_string(N),
        kDamaged);
  std::vector<glm::vec<N, float>> out(attribute.values.size() / N);
  for (std::size_t i = 0; i < out.size(); ++i)
    for (int c = 0; c < N; ++c) {
      const float value = attribute.values[i * N + static_cast<std::size_t>(c)];
      out[i][c] = divisor == 1.0f ? value : std::max(value / divisor, -1.0f);
    }
  return out;
}

std::vector<glm::vec4> with_alpha(const std::vector<glm::vec3>& colors) {
  std::vector<glm::vec4> out;
  out.reserve(colors.size());
  for (const glm::vec3& rgb : colors) out.emplace_back(rgb, 1.0f);
  return out;
}

}  // namespace

AttributeReader::AttributeReader(const Document& document, PrimitiveTask* task)
    : document_(document),
      task_(*task),
      where_(at(document.path, task->name())),
      json_(element_json(document, "meshes", task->mesh)["primitives"][task->primitive]) {
  const Json* compressed = find_extension(json_, kDraco);
  if (compressed != nullptr) decode(*compressed);
}

void AttributeReader::decode(const Json& compressed) {
  std::map<std::string, std::uint32_t> ids;
  for (auto it = compressed["attributes"].begin(); it != compressed["attributes"].end(); ++it)
    if (has(it.key())) ids[it.key()] = it.value().get<std::uint32_t>();
  draco_ = decode_draco(where_, view_bytes(document_, compressed["bufferView"].get<std::size_t>()), ids);
  compressed_ = true;
  check_draco_counts();
}

/// The stream is what can be drawn; another count in the file is a mistake of its writer.
void AttributeReader::check_draco_counts() const {
  const auto count_of = [&](std::size_t accessor) { return document_.model.accessors[accessor].count; };
  bool agree = !json_.contains("indices") || count_of(json_["indices"].get<std::size_t>()) == draco_.indices.size();
  for (const auto& [name, attribute] : draco_.attributes)
    agree = agree && count_of(accessor_of(name.c_str())) == draco_.vertex_count;
  if (!agree) task_.warnings.add("the counts of its accessors contradict its Draco data, which is used", task_.name());
}

template <int N>
std::vector<glm::vec<N, float>> AttributeReader::read_base(const char* name) const {
  if (!has(name)) return {};
  const std::size_t accessor = accessor_of(name);
  if (const auto found = draco_.attributes.find(name); found != draco_.attributes.end())
    return to_vectors<N>(found->second, divisor_of(found->second, document_.model.accessors[accessor]),
                         where_ + "." + name);
  return read_vectors<N>(document_, accessor);
}

/// Adds the targets' differences of N components to values of M.
/// Source: glTF 2.0, 3.7.2.2.
template <int N, int M>
void AttributeReader::add_targets(const char* name, std::vector<glm::vec<M, float>>* values) const {
  if (task_.use == nullptr || values->empty() || !json_.contains("targets")) return;
  const Json& targets = json_["targets"];
  const std::vector<float>& weights = task_.use->weights;
  for (std::size_t t = 0; t < std::min(targets.size(), weights.size()); ++t) {
    if (weights[t] == 0.0f || !targets[t].contains(name)) continue;
    const std::vector<glm::vec<N, float>> differences =
        read_vectors<N>(document_, targets[t][name].template get<std::size_t>());
    if (differences.size() != values->size())
      throw Error(
          where_ + "." + element("targets", t) + "." + name,
          "has " + std::to_string(differences.size()) + " values for " + std::to_string(values->size()) + " vertices",
          kDamaged);
    for (std::size_t i = 0; i < values->size(); ++i)
      for (int c = 0; c < N; ++c) (*values)[i][c] += weights[t] * differences[i][c];
  }
}

template <int N>
std::vector<glm::vec<N, float>> AttributeReader::read(const char* name) const {
  std::vector<glm::vec<N, float>> out = read_base<N>(name);
  add_targets<N, N>(name, &out);
  return out;
}
template std::vector<glm::vec2> AttributeReader::read<2>(const char*) const;
template std::vector<glm::vec3> AttributeReader::read<3>(const char*) const;
template std::vector<glm::vec4> AttributeReader::read<4>(const char*) const;

std::vector<glm::vec4> AttributeReader::read_tangents() const {
  std::vector<glm::vec4> out = read_base<4>("TANGENT");
  add_targets<3, 4>("TANGENT", &out);
  return out;
}

std::vector<glm::vec4> AttributeReader::read_colors() const {
  constexpr const char* kName = "COLOR_0";
  if (!has(kName)) return {};
  tinygltf::Accessor accessor = document_.model.accessors[accessor_of(kName)];
  if (!accessor.normalized && largest_of(accessor.componentType) > 0.0f) {
    task_.warnings.add("COLOR_0 of integers that are not normalized is taken as normalized", task_.name());
    accessor.normalized = true;
  }
  std::vector<glm::vec4> out;
  if (const auto found = draco_.attributes.find(kName); found != draco_.attributes.end()) {
    const float divisor = divisor_of(found->second, accessor);
    out = found->second.components == 4 ? to_vectors<4>(found->second, divisor, where_ + "." + kName)
                                        : with_alpha(to_vectors<3>(found->second, divisor, where_ + "." + kName));
  } else if (accessor.type == TINYGLTF_TYPE_VEC4) {
    out = read_vectors<4>(document_, accessor_of(kName), Integers::normalized);
  } else {
    out = with_alpha(read_vectors<3>(document_, accessor_of(kName), Integers::normalized));
  }
  if (task_.use == nullptr || !json_.contains("targets")) return out;
  const auto is_rgba = [&](const Json& target) {
    return target.contains(kName) &&
           document_.model.accessors[target[kName].get<std::size_t>()].type == TINYGLTF_TYPE_VEC4;
  };
  const Json& targets = json_["targets"];
  std::any_of(targets.begin(), targets.end(), is_rgba) ? add_targets<4, 4>(kName, &out)
                                                       : add_targets<3, 4>(kName, &out);
  for (glm::vec4& color : out) color = glm::clamp(color, 0.0f, 1.0f);  // as the specification demands after targets
  return out;
}

std::vector<std::uint32_t> AttributeReader::read_indices(std::size_t vertex_count) {
  if (compressed_) return std::move(draco_.indices);
  if (json_.contains("indices")) return gltf::read_indices(document_, json_["indices"].get<std::size_t>());
  std::vector<std::uint32_t> indices(vertex_count);
  std::iota(indices.begin(), indices.end(), 0u);
  return indices;
}

}  // namespace maquette::gltf
