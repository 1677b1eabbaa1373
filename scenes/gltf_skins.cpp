#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "scenes/error.h"
#include "scenes/gltf_primitive.h"

namespace maquette::gltf {
namespace {

constexpr std::size_t kMostJointSets = 8;  ///< of four joints each

/// Weights of a node's mesh without the zeros at the end: the node's own, or the mesh's; none without targets.
std::vector<float> weights_of(const Json& mesh, const Json* node) {
  std::vector<float> out;
  if (std::none_of(mesh["primitives"].begin(), mesh["primitives"].end(),
                   [](const Json& primitive) { return primitive.contains("targets"); }))
    return out;
  const Json& holder = node != nullptr && node->contains("weights") ? *node : mesh;
  if (const auto found = holder.find("weights"); found != holder.end())
    for (const Json& weight : *found) out.push_back(static_cast<float>(weight.get<double>()));
  while (!out.empty() && out.back() == 0.0f) out.pop_back();
  return out;
}

bool has_joints(const Json& mesh) {
  return std::any_of(mesh["primitives"].begin(), mesh["primitives"].end(),
                     [](const Json& primitive) { return primitive["attributes"].contains("JOINTS_0"); });
}

/// Matrices that take bound vertices to the space `from`, or to the world without.
/// Source: glTF 2.0, 3.7.3.3.
std::vector<glm::dmat4> joint_matrices(const Document& document, std::size_t skin, const std::vector<glm::dmat4>& world,
                                       const glm::dmat4& node_from_world) {
  const Json& json = element_json(document, "skins", skin);
  std::vector<glm::mat4> bound;
  if (const auto found = json.find("inverseBindMatrices");
      found != json.end() && !lacks_bytes(document, found->get<std::size_t>())) {
    bound = read_matrices(document, found->get<std::size_t>());
    if (bound.size() < json["joints"].size())
      throw Error(
          at(document.path, element("skins", skin) + ".inverseBindMatrices"),
          "has " + std::to_string(bound.size()) + " matrices for " + std::to_string(json["joints"].size()) + " joints",
          kDamaged);
  }
  std::vector<glm::dmat4> out;
  for (std::size_t j = 0; j < json["joints"].size(); ++j) {
    const glm::dmat4 joint = node_from_world * world[json["joints"][j].get<std::size_t>()];
    out.push_back(bound.empty() ? joint : joint * glm::dmat4(bound[j]));
  }
  return out;
}

/// The use of a skinned mesh: vertices go to the node's space, because a scene has them there.
void bind_skin(const Document& document, std::size_t node, const std::vector<glm::dmat4>& world, MeshUse* use) {
  const auto skin = element_json(document, "nodes", node)["skin"].get<std::size_t>();
  const glm::dmat4 node_from_world = glm::inverse(world[node]);
  bool regular = glm::determinant(world[node]) != 0.0;
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) regular = regular && std::isfinite(node_from_world[c][r]);
  use->detached = !regular;
  use->joints = joint_matrices(document, skin, world, regular ? node_from_world : glm::dmat4(1.0));
}

/// Collects the uses; one that is like another shares its mesh.
class UseCollector {
 public:
  explicit UseCollector(Document* document) : document_(*document) {}

  void add_node(std::size_t node, const std::vector<glm::dmat4>& world) {
    const Json& json = element_json(document_, "nodes", node);
    if (!json.contains("mesh")) return;
    MeshUse use;
    use.mesh = json["mesh"].get<std::size_t>();
    const Json& mesh = element_json(document_, "meshes", use.mesh);
    use.weights = weights_of(mesh, &json);
    const bool skinned = json.contains("skin") && has_joints(mesh);
    if (skinned) bind_skin(document_, node, world, &use);
    const std::pair<std::size_t, std::vector<float>> key{use.mesh, use.weights};
    if (const auto found = shared_.find(key); !skinned && found != shared_.end()) {
      document_.node_uses[node] = static_cast<int>(found->second);
      return;
    }
    const std::size_t index = place(std::move(use));
    if (!skinned) shared_[key] = index;
    document_.node_uses[node] = static_cast<int>(index);
  }

  /// The first use of a mesh has the mesh's own index; meshes without use keep it.
  void fill(std::size_t mesh_count) {
    document_.mesh_uses.resize(mesh_count);
    taken_.assign(mesh_count, false);
    for (std::size_t m = 0; m < mesh_count; ++m) {
      document_.mesh_uses[m].mesh = m;
      document_.mesh_uses[m].weights = weights_of(element_json(document_, "meshes", m), nullptr);
    }
  }

 private:
  std::size_t place(MeshUse use) {
    const std::size_t mesh = use.mesh;
    if (!taken_[mesh]) {
      taken_[mesh] = true;
      document_.mesh_uses[mesh] = std::move(use);
      return mesh;
    }
    document_.mesh_uses.push_back(std::move(use));
    return document_.mesh_uses.size() - 1;
  }

  Document& document_;
  std::vector<bool> taken_;
  std::map<std::pair<std::size_t, std::vector<float>>, std::size_t> shared_;
};

/// Blend of the joints of one vertex. Weights whose sum is not 1 are scaled; without any, the first joint counts.
struct Influences {
  std::vector<std::vector<glm::vec4>> joints, weights;

  glm::dmat4 blend(std::size_t vertex, const std::vector<glm::dmat4>& matrices, const std::string& where) const {
    glm::dmat4 out(0.0);
    double sum = 0.0;
    for (std::size_t set = 0; set < joints.size(); ++set) {
      for (int c = 0; c < 4; ++c) {
        const auto weight = static_cast<double>(weights[set][vertex][c]);
        if (!(weight > 0.0) || !std::isfinite(weight)) continue;
        out += weight * matrix(matrices, joints[set][vertex][c], where);
        sum += weight;
      }
    }
    return sum > 0.0 ? out * (1.0 / sum) : matrix(matrices, joints[0][vertex][0], where);
  }

  static const glm::dmat4& matrix(const std::vector<glm::dmat4>& matrices, float joint, const std::string& where) {
    if (!(joint >= 0.0f && joint < static_cast<float>(matrices.size())))
      throw Error(where,
                  "a vertex follows joint " + std::to_string(static_cast<long>(joint)) + " of " +
                      std::to_string(matrices.size()),
                  kDamaged);
    return matrices[static_cast<std::size_t>(joint)];
  }
};

glm::vec3 unit_or_zero(const glm::dvec3& v) {
  const double length = glm::length(v);
  return length > 0.0 && std::isfinite(length) ? glm::vec3(v / length) : glm::vec3(0.0f);
}

}  // namespace

void find_mesh_uses(Document* document) {
  const auto meshes = document->root.find("meshes");
  document->node_uses.assign(document->model.nodes.size(), -1);
  UseCollector collector(document);
  collector.fill(meshes == document->root.end() ? 0 : meshes->size());
  std::vector<glm::dmat4> world;
  if (document->root.contains("skins")) world = world_of_nodes(*document);
  for (std::size_t i = 0; i < document->model.nodes.size(); ++i)
    if (document->tree.reached[i]) collector.add_node(i, world);
}

void apply_skin(const AttributeReader& reader, PrimitiveTask* task) {
  if (task->use == nullptr || task->use->joints.empty() || !reader.has("JOINTS_0")) return;
  Primitive& out = task->out;
  Influences influences;
  for (std::size_t set = 0; set < kMostJointSets; ++set) {
    const std::string suffix = std::to_string(set);
    if (!reader.has("JOINTS_" + suffix)) break;
    influences.joints.push_back(reader.read<4>(("JOINTS_" + suffix).c_str()));
    influences.weights.push_back(reader.read<4>(("WEIGHTS_" + suffix).c_str()));
    if (influences.joints.back().size() != out.positions.size() ||
        influences.weights.back().size() != out.positions.size())
      throw Error(reader.where(), "JOINTS_" + suffix + " and WEIGHTS_" + suffix + " do not have one value a vertex",
                  kDamaged);
  }
  for (std::size_t i = 0; i < out.positions.size(); ++i) {
    const glm::dmat4 blend = influences.blend(i, task->use->joints, reader.where());
    const glm::dmat3 linear(blend);
    out.positions[i] = glm::vec3(blend * glm::dvec4(out.positions[i], 1.0));
    // Cofactors instead of the inverse transpose: they exist for a singular matrix too.
    const glm::dmat3 cofactors(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                               glm::cross(linear[0], linear[1]));
    const double side = glm::determinant(linear) < 0.0 ? -1.0 : 1.0;
    if (!out.normals.empty()) out.normals[i] = unit_or_zero(side * (cofactors * glm::dvec3(out.normals[i])));
    if (!out.tangents.empty())
      out.tangents[i] = glm::vec4(unit_or_zero(linear * glm::dvec3(out.tangents[i])), out.tangents[i].w);
  }
}

}  // namespace maquette::gltf
