#pragma once

#include <map>
#include <string>
#include <vector>

#include "scenes/gltf_document.h"
#include "scenes/gltf_draco.h"

namespace maquette::gltf {

/// Import of one primitive as one use of its mesh needs it.
struct PrimitiveTask {
  std::size_t mesh = 0, primitive = 0;  ///< in the file
  const MeshUse* use = nullptr;
  std::size_t cost = 0;
  Primitive out;
  bool drawable = true;
  Warnings warnings;
  std::string name() const { return element("meshes", mesh) + "." + element("primitives", primitive); }
};

/// Reads attributes of one primitive from its accessors or its Draco stream, morphed by the weights of its use.
class AttributeReader {
 public:
  AttributeReader(const Document& document, PrimitiveTask* task);

  const Json& json() const { return json_; }
  const std::string& where() const { return where_; }
  bool has(const std::string& name) const { return json_["attributes"].contains(name); }

  /// Empty without the attribute.
  template <int N>
  std::vector<glm::vec<N, float>> read(const char* name) const;
  std::vector<glm::vec4> read_tangents() const;  ///< TANGENT: targets move x, y and z alone
  std::vector<glm::vec4> read_colors() const;    ///< COLOR_0
  /// Moves the decoded indices of a Draco stream out.
  std::vector<std::uint32_t> read_indices(std::size_t vertex_count);

 private:
  template <int N>
  std::vector<glm::vec<N, float>> read_base(const char* name) const;
  template <int N, int M>
  void add_targets(const char* name, std::vector<glm::vec<M, float>>* values) const;
  void decode(const Json& compressed);
  void check_draco_counts() const;
  std::size_t accessor_of(const char* name) const { return json_["attributes"][name].get<std::size_t>(); }

  const Document& document_;
  PrimitiveTask& task_;
  std::string where_;
  const Json& json_;
  DracoMesh draco_;
  bool compressed_ = false;
};

/// Moves positions, normals and tangents by the joints of the use's skin.
void apply_skin(const AttributeReader& reader, PrimitiveTask* task);

/// Drops and replaces what is not finite or out of range, with warnings.
void repair_primitive(PrimitiveTask* task);

/// Normals of the triangles. Vertices between triangles of different normals are duplicated, behind the others.
/// Source: glTF 2.0, 3.7.2.1: flat normals, and tangents of the file are ignored.
void add_flat_normals(Primitive* primitive);

}  // namespace maquette::gltf
