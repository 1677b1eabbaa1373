#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace maquette::gltf {

/// A decoded attribute: `components` numbers a vertex as they are stored.
struct DracoAttribute {
  int components = 0;
  float integer_max = 0.0f;  ///< largest value of the stored type; 0: floats
  bool normalized = false;   ///< what the stream says of its integers; the accessor's word counts
  std::vector<float> values;
};

struct DracoMesh {
  std::size_t vertex_count = 0;
  std::vector<std::uint32_t> indices;
  std::map<std::string, DracoAttribute> attributes;  ///< by glTF name
};

/// Decodes one KHR_draco_mesh_compression stream; `attribute_ids` maps glTF names to Draco's unique ids.
/// Throws Error(where, ...) for damaged data or missing attributes.
DracoMesh decode_draco(const std::string& where, std::span<const std::byte> bytes,
                       const std::map<std::string, std::uint32_t>& attribute_ids);

}  // namespace maquette::gltf
