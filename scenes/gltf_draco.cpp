#include "scenes/gltf_draco.h"

#include <draco/compression/decode.h>

#include <array>
#include <cstring>
#include <limits>
#include <new>
#include <stdexcept>

#include "scenes/error.h"
#include "scenes/gltf_file.h"

namespace maquette::gltf {
namespace {

/// Largest value of an integer type; 0 for others.
float largest_of(draco::DataType type) {
  switch (type) {
    case draco::DT_INT8:
      return std::numeric_limits<std::int8_t>::max();
    case draco::DT_UINT8:
      return std::numeric_limits<std::uint8_t>::max();
    case draco::DT_INT16:
      return std::numeric_limits<std::int16_t>::max();
    case draco::DT_UINT16:
      return std::numeric_limits<std::uint16_t>::max();
    case draco::DT_INT32:
      return static_cast<float>(std::numeric_limits<std::int32_t>::max());
    case draco::DT_UINT32:
      return static_cast<float>(std::numeric_limits<std::uint32_t>::max());
    default:
      return 0.0f;
  }
}

/// Integers as they are stored: Draco maps those that it calls normalized to floats itself.
bool read_integers(const draco::PointAttribute& attribute, draco::AttributeValueIndex entry, std::size_t components,
                   float* target) {
  std::array<std::int64_t, 4> values{};
  if (!attribute.ConvertValue<std::int64_t>(entry, static_cast<std::int8_t>(components), values.data())) return false;
  for (std::size_t c = 0; c < components; ++c) target[c] = static_cast<float>(values[c]);
  return true;
}

DracoAttribute read_attribute(const std::string& where, const draco::Mesh& mesh, const std::string& name,
                              std::uint32_t id) {
  const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(id);
  if (attribute == nullptr)
    throw Error(where, "its Draco data has no attribute " + std::to_string(id) + " for " + name, kDamaged);
  DracoAttribute out;
  out.components = attribute->num_components();
  if (out.components < 1 || out.components > 4)
    throw Error(where, name + " has " + std::to_string(out.components) + " components in its Draco data", kDamaged);
  const auto components = static_cast<std::size_t>(out.components);
  out.integer_max = largest_of(attribute->data_type());
  out.normalized = attribute->normalized();
  const std::size_t count = mesh.num_points();
  out.values.resize(count * components);
  const bool plain = attribute->data_type() == draco::DT_FLOAT32 &&
                     attribute->byte_stride() == static_cast<std::int64_t>(components * sizeof(float));
  const std::size_t entry_count = attribute->size();
  for (std::size_t i = 0; i < count; ++i) {
    const draco::AttributeValueIndex entry = attribute->mapped_index(draco::PointIndex(static_cast<std::uint32_t>(i)));
    if (entry.value() >= entry_count) throw Error(where, "its Draco data points outside " + name, kDamaged);
    float* target = out.values.data() + i * components;
    if (plain) {
      std::memcpy(target, attribute->GetAddress(entry), components * sizeof(float));
    } else if (!(out.integer_max > 0.0f ? read_integers(*attribute, entry, components, target)
                                        : attribute->ConvertValue<float>(entry, target))) {
      throw Error(where, "its Draco data has an unreadable " + name, kDamaged);
    }
  }
  return out;
}

DracoMesh convert(const std::string& where, const draco::Mesh& mesh,
                  const std::map<std::string, std::uint32_t>& attribute_ids) {
  DracoMesh out;
  out.vertex_count = mesh.num_points();
  out.indices.resize(std::size_t{3} * mesh.num_faces());
  for (std::uint32_t f = 0; f < mesh.num_faces(); ++f) {
    const draco::Mesh::Face& face = mesh.face(draco::FaceIndex(f));
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::uint32_t index = face[corner].value();
      if (index >= out.vertex_count) throw Error(where, "its Draco data has a triangle out of range", kDamaged);
      out.indices[std::size_t{3} * f + corner] = index;
    }
  }
  for (const auto& [name, id] : attribute_ids) out.attributes.emplace(name, read_attribute(where, mesh, name, id));
  return out;
}

}  // namespace

DracoMesh decode_draco(const std::string& where, std::span<const std::byte> bytes,
                       const std::map<std::string, std::uint32_t>& attribute_ids) {
  try {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::Decoder decoder;
    const auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok())
      throw Error(where, std::string("its Draco data cannot be decoded: ") + decoded.status().error_msg(), kDamaged);
    return convert(where, *decoded.value(), attribute_ids);
  } catch (const std::bad_alloc&) {
    throw Error(where, "its Draco data asks for more memory than there is", kDamaged);
  } catch (const std::length_error&) {
    throw Error(where, "its Draco data asks for more memory than there is", kDamaged);
  }
}

}  // namespace maquette::gltf
