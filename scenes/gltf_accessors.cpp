#include <cstring>
#include <limits>

#include "scenes/error.h"
#include "scenes/gltf_document.h"

namespace maquette::gltf {
namespace {

/// Limit for accessors without a buffer view: they consist of zeros, so that a small file could request any size.
constexpr std::size_t kMaxZeroElements = std::size_t{1} << 24;

struct Strided {
  const std::byte* data = nullptr;  ///< null: zeros
  std::size_t stride = 0;
  std::size_t count = 0;
  int component_type = 0;
  int components = 0;
  bool normalized = false;
};

std::string name_of(const Document& document, std::size_t accessor) {
  return at(document.path, element("accessors", accessor));
}

std::size_t component_bytes(int component_type) {
  switch (component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      return 0;
  }
}

/// Locates `count` elements of `element_bytes` in a view. The arithmetic cannot overflow: all inputs are below 2^53 or
/// bounded.
Strided locate_elements(const Document& document, const std::string& where, std::size_t view, std::size_t byte_offset,
                        std::size_t count, std::size_t element_bytes) {
  const Bytes bytes = view_bytes(document, view);
  Strided out;
  out.stride = document.model.bufferViews[view].byteStride;
  if (out.stride == 0) out.stride = element_bytes;
  if (out.stride < element_bytes)
    throw Error(where,
                "elements of " + std::to_string(element_bytes) + " bytes overlap in " + element("bufferViews", view) +
                    " with byteStride " + std::to_string(out.stride),
                kDamaged);
  out.count = count;
  const bool fits = count == 0 || (byte_offset <= bytes.size() && element_bytes <= bytes.size() - byte_offset &&
                                   (count - 1) <= (bytes.size() - byte_offset - element_bytes) / out.stride);
  if (!fits)
    throw Error(where,
                std::to_string(count) + " elements from byte " + std::to_string(byte_offset) + " do not fit in " +
                    element("bufferViews", view) + " of " + std::to_string(bytes.size()) + " bytes",
                kDamaged);
  if (count > 0) out.data = bytes.data() + byte_offset;
  return out;
}

Strided resolve(const Document& document, std::size_t index, int components) {
  const tinygltf::Accessor& accessor = document.model.accessors[index];
  const std::string where = name_of(document, index);
  const std::size_t size = component_bytes(accessor.componentType);
  if (size == 0)
    throw Error(where, "componentType " + std::to_string(accessor.componentType) + " is not one of glTF's", kDamaged);
  const int found = tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(accessor.type));
  if (found != components)
    throw Error(where,
                "has " + std::to_string(found) + " components an element, " + std::to_string(components) +
                    " are needed for its use",
                kDamaged);
  Strided out;
  if (accessor.bufferView >= 0) {
    out = locate_elements(document, where, static_cast<std::size_t>(accessor.bufferView), accessor.byteOffset,
                          accessor.count, size * static_cast<std::size_t>(components));
  } else if (accessor.count > kMaxZeroElements) {
    throw Error(where, "asks for " + std::to_string(accessor.count) + " elements without a bufferView", kDamaged);
  }
  out.count = accessor.count;
  out.component_type = accessor.componentType;
  out.components = components;
  out.normalized = accessor.normalized;
  return out;
}

template <typename T>
float convert(const std::byte* bytes, bool normalized) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  const float number = static_cast<float>(value);
  if constexpr (std::numeric_limits<T>::is_integer)
    if (normalized) return std::max(number / static_cast<float>(std::numeric_limits<T>::max()), -1.0f);
  return number;
}

template <typename T>
void convert_all(const Strided& source, float* target) {
  for (std::size_t i = 0; i < source.count; ++i)
    for (int c = 0; c < source.components; ++c)
      *target++ =
          convert<T>(source.data + i * source.stride + sizeof(T) * static_cast<std::size_t>(c), source.normalized);
}

void to_floats(const Strided& source, float* target) {
  if (source.data == nullptr) return;
  switch (source.component_type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return convert_all<std::int8_t>(source, target);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return convert_all<std::uint8_t>(source, target);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return convert_all<std::int16_t>(source, target);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return convert_all<std::uint16_t>(source, target);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return convert_all<std::uint32_t>(source, target);
    default:
      break;
  }
  const std::size_t bytes = sizeof(float) * static_cast<std::size_t>(source.components);
  if (source.stride == bytes) {
    std::memcpy(target, source.data, source.count * bytes);
  } else {
    convert_all<float>(source, target);
  }
}

template <typename T>
std::uint32_t integer_at(const std::byte* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<std::uint32_t>(value);
}

std::vector<std::uint32_t> to_integers(const std::string& where, const Strided& source) {
  std::vector<std::uint32_t> out(source.count);
  const bool is_unsigned = source.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                           source.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                           source.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
  if (!is_unsigned)
    throw Error(where, "componentType " + std::to_string(source.component_type) + " cannot hold indices", kDamaged);
  for (std::size_t i = 0; i < source.count && source.data != nullptr; ++i) {
    const std::byte* bytes = source.data + i * source.stride;
    out[i] = source.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE    ? integer_at<std::uint8_t>(bytes)
             : source.component_type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ? integer_at<std::uint16_t>(bytes)
                                                                               : integer_at<std::uint32_t>(bytes);
  }
  return out;
}

/// Replaces elements as specified by `accessors[index].sparse`; `store(element, source, i)` stores the i-th sparse
/// value.
template <typename Store>
void apply_sparse(const Document& document, std::size_t index, const Strided& dense, const Store& store) {
  const auto& sparse = document.model.accessors[index].sparse;
  if (!sparse.isSparse) return;
  const std::string where = name_of(document, index) + ".sparse";
  const std::size_t index_bytes = component_bytes(sparse.indices.componentType);
  const Json& json = element_json(document, "accessors", index)["sparse"];  // tinygltf narrows these to int
  const auto count = json["count"].get<std::size_t>();
  const auto index_offset = json["indices"].value("byteOffset", std::size_t{0});
  const auto value_offset = json["values"].value("byteOffset", std::size_t{0});
  if (index_bytes == 0) throw Error(where, "componentType of its indices is not one of glTF's", kDamaged);
  Strided places = locate_elements(document, where, static_cast<std::size_t>(sparse.indices.bufferView), index_offset,
                                   count, index_bytes);
  places.component_type = sparse.indices.componentType;
  const std::size_t bytes = component_bytes(dense.component_type) * static_cast<std::size_t>(dense.components);
  Strided values =
      locate_elements(document, where, static_cast<std::size_t>(sparse.values.bufferView), value_offset, count, bytes);
  values.component_type = dense.component_type;
  values.components = dense.components;
  values.normalized = dense.normalized;
  const std::vector<std::uint32_t> targets = to_integers(where, places);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    if (targets[i] >= dense.count)
      throw Error(where, "replaces element " + std::to_string(targets[i]) + " of " + std::to_string(dense.count),
                  kDamaged);
    Strided one = values;
    one.data += i * values.stride;
    one.count = 1;
    store(targets[i], one);
  }
}

}  // namespace

Bytes view_bytes(const Document& document, std::size_t view) {
  const tinygltf::BufferView& bounds = document.model.bufferViews[view];
  if (view < document.decoded_views.size() && !document.decoded_views[view].empty())
    return document.decoded_views[view];
  const auto index = static_cast<std::size_t>(bounds.buffer);
  const Bytes buffer = document.buffers[index];
  if (const auto fault = document.buffer_faults.find(index); fault != document.buffer_faults.end()) throw fault->second;
  if (buffer.data() == nullptr && bounds.byteLength > 0)
    throw Error(at(document.path, element("buffers", index)),
                document.root["buffers"][index].contains("uri") ? "is a fallback that is not read" : "has no uri",
                kDamaged);
  if (bounds.byteOffset > buffer.size() || bounds.byteLength > buffer.size() - bounds.byteOffset)
    throw Error(at(document.path, element("bufferViews", view)),
                "bytes " + std::to_string(bounds.byteOffset) + " to " +
                    std::to_string(bounds.byteOffset + bounds.byteLength) + " are outside " +
                    element("buffers", static_cast<std::size_t>(bounds.buffer)) + " of " +
                    std::to_string(buffer.size()) + " bytes",
                kDamaged);
  return buffer.subspan(bounds.byteOffset, bounds.byteLength);
}

bool lacks_bytes(const Document& document, std::size_t accessor) {
  const int view = document.model.accessors[accessor].bufferView;
  if (view < 0) return false;
  const auto v = static_cast<std::size_t>(view);
  if (v < document.decoded_views.size() && !document.decoded_views[v].empty()) return false;
  const auto buffer = static_cast<std::size_t>(document.model.bufferViews[v].buffer);
  return document.buffers[buffer].data() == nullptr && !document.buffer_faults.contains(buffer) &&
         !document.root["buffers"][buffer].contains("uri");
}

template <int N>
std::vector<glm::vec<N, float>> read_vectors(const Document& document, std::size_t accessor, Integers integers) {
  Strided dense = resolve(document, accessor, N);
  if (integers == Integers::normalized) dense.normalized = true;
  std::vector<glm::vec<N, float>> out(dense.count, glm::vec<N, float>(0.0f));
  static_assert(sizeof(glm::vec<N, float>) == N * sizeof(float));
  auto* floats = reinterpret_cast<float*>(out.data());
  to_floats(dense, floats);
  apply_sparse(document, accessor, dense,
               [&](std::uint32_t i, const Strided& value) { to_floats(value, floats + std::size_t{i} * N); });
  return out;
}
template std::vector<glm::vec2> read_vectors<2>(const Document&, std::size_t, Integers);
template std::vector<glm::vec3> read_vectors<3>(const Document&, std::size_t, Integers);
template std::vector<glm::vec4> read_vectors<4>(const Document&, std::size_t, Integers);

std::vector<glm::mat4> read_matrices(const Document& document, std::size_t accessor) {
  if (document.model.accessors[accessor].type != TINYGLTF_TYPE_MAT4 ||
      document.model.accessors[accessor].componentType != TINYGLTF_COMPONENT_TYPE_FLOAT)
    throw Error(name_of(document, accessor), "does not hold matrices of 4 x 4 floats", kDamaged);
  const Strided dense = resolve(document, accessor, 16);
  std::vector<glm::mat4> out(dense.count, glm::mat4(0.0f));
  auto* floats = reinterpret_cast<float*>(out.data());
  to_floats(dense, floats);
  apply_sparse(document, accessor, dense,
               [&](std::uint32_t i, const Strided& value) { to_floats(value, floats + std::size_t{i} * 16); });
  return out;
}

std::vector<std::uint32_t> read_indices(const Document& document, std::size_t accessor) {
  const Strided dense = resolve(document, accessor, 1);
  const std::string where = name_of(document, accessor);
  std::vector<std::uint32_t> out = to_integers(where, dense);
  apply_sparse(document, accessor, dense,
               [&](std::uint32_t i, const Strided& value) { out[i] = to_integers(where, value)[0]; });
  return out;
}

std::vector<float> read_scalars(const Document& document, std::size_t accessor) {
  const Strided dense = resolve(document, accessor, 1);
  std::vector<float> out(dense.count, 0.0f);
  to_floats(dense, out.data());
  apply_sparse(document, accessor, dense, [&](std::uint32_t i, const Strided& value) { to_floats(value, &out[i]); });
  return out;
}

}  // namespace maquette::gltf
