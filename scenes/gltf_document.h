#pragma once

#include <tiny_gltf.h>

#include <array>
#include <glm/glm.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "scenes/error.h"
#include "scenes/gltf_file.h"
#include "scenes/scene.h"

namespace maquette::gltf {

/// Nodes of the file.
struct NodeTree {
  std::vector<int> parents;       ///< -1: none
  std::vector<int> roots;         ///< of the scene that is imported
  std::vector<bool> reached;      ///< from these roots
  std::vector<glm::dmat4> local;  ///< parent_from_node
};

/// A mesh as one or several nodes show it: in its rest pose.
struct MeshUse {
  std::size_t mesh = 0;            ///< in the file
  std::vector<float> weights;      ///< of morph targets; those beyond are 0
  std::vector<glm::dmat4> joints;  ///< node_from_bound of each joint; empty: no skin
  bool detached = false;           ///< the node's space has no volume: joints are world_from_bound
};

/// One opened file during its import. Core members come from `model`; extensions and extras, which tinygltf does not
/// keep in our build, come from `root`. Both have been checked: indices are valid, members have their type.
struct Document {
  std::string path;
  std::vector<std::byte> file;
  Json root;
  tinygltf::Model model;  ///< without buffers, images, materials, extensions and extras
  std::vector<std::vector<std::byte>> owned_buffers;
  std::vector<Bytes> buffers;
  std::map<std::size_t, Error> buffer_faults;  ///< of those that cannot be read: thrown where their bytes are needed
  std::vector<std::vector<std::byte>> decoded_views;  ///< of EXT_meshopt_compression; empty: as in the buffer
  NodeTree tree;
  std::vector<MeshUse> mesh_uses;  ///< one for each mesh of the scene; those of the file come first
  std::vector<int> node_uses;      ///< of each node of the file: its mesh in the scene, or -1
  std::size_t instance_count = 0;  ///< of EXT_mesh_gpu_instancing, of all nodes read so far
  std::size_t animation_keys = 0;  ///< of all animations read so far
  Warnings warnings;
};

/// Opens the file for its scene of that name or index (empty: its default). Throws Error naming `path` and the element
/// at fault, UsageError for a scene that is not there.
Document open_document(const std::string& path, const std::string& scene);
/// At the end of the import: names the buffers that could not be read and that nothing needed.
void warn_of_buffers(Document* document);

/// Decodes the buffer views of EXT_meshopt_compression in parallel.
void decode_views(Document* document);
/// True for a buffer whose views are all compressed elsewhere, so that its own bytes are not needed.
bool is_fallback(const Json& buffer);

/// Fills `tree`.
void import_tree(Document* document, const std::string& scene);
/// world_from_node of all nodes of the file.
std::vector<glm::dmat4> world_of_nodes(const Document& document);
/// Fills `mesh_uses` and `node_uses`.
void find_mesh_uses(Document* document);

/// Bytes of a buffer view, checked against its buffer.
Bytes view_bytes(const Document& document, std::size_t view);
/// True for an accessor into a buffer that has no uri: glTF leaves open where its bytes are, and nothing here says it.
bool lacks_bytes(const Document& document, std::size_t accessor);

/// Accessors, converted to float: normalised integers are mapped to [0, 1] or [-1, 1], sparse values are inserted.
/// Throws Error: wrong type, outside its view, too many elements.
enum class Integers { as_stored, normalized };  ///< as the accessor says, or always as fractions of the largest
template <int N>
std::vector<glm::vec<N, float>> read_vectors(const Document& document, std::size_t accessor,
                                             Integers integers = Integers::as_stored);
/// Reads MAT4.
std::vector<glm::mat4> read_matrices(const Document& document, std::size_t accessor);
/// Reads SCALAR of an unsigned integer type.
std::vector<std::uint32_t> read_indices(const Document& document, std::size_t accessor);
std::vector<float> read_scalars(const Document& document, std::size_t accessor);

/// Decodes images in parallel; an unreadable image stays empty and causes a warning. An image that only stands in
/// for a readable WebP image stays empty too.
void import_images(Document* document, Scene* scene);
/// The image that a texture shows: that of EXT_texture_webp if it is readable or the only one, otherwise `source`.
std::optional<std::size_t> image_of_texture(const Json& texture, const Scene& scene);
/// Fills images, materials (textures included) and variants.
void import_materials(Document* document, Scene* scene);
/// Fills meshes, decoding primitives in parallel.
void import_meshes(Document* document, Scene* scene);
/// Index in the scene of each camera and lamp of the file, -1 for what is left out.
struct Fixtures {
  std::vector<int> cameras, lights;
};
/// Fills cameras and lights. What is wrong with one is repaired or it is left out, with one warning of it.
Fixtures import_fixtures(Document* document, Scene* scene);
/// Index in the scene of a node's camera or lamp; one that is not there is left out with a warning.
int camera_of_node(Document* document, const Fixtures& fixtures, std::size_t node);
int light_of_node(Document* document, const Fixtures& fixtures, std::size_t node);
/// Gives every node a camera of its own with a name; leaves out cameras in spaces without volume.
void place_cameras(Document* document, Scene* scene);
/// Fills animations. `scene_nodes`: index in the scene of each node of the file, -1 for those that are left out.
void import_animations(Document* document, const std::vector<int>& scene_nodes, Scene* scene);
/// Fills nodes, roots, cameras, lights, patches and animations; only what the default scene refers to.
void import_nodes(Document* document, Scene* scene);

/// Imports `extras.maquette` (docs/formats.md): control cages of meshes, Bezier patches, flags of nodes.
void import_cages(const Document& document, Scene* scene);
void import_patches(const Document& document, Scene* scene);
void import_node_extras(const Json& json, const std::string& where, const Scene& scene, Node* node);

/// `extras.maquette` of an element, or null.
const Json* find_extras(const Json& element);
const Json* find_extension(const Json& element, const char* name);
/// Element of a top-level array of the JSON.
const Json& element_json(const Document& document, const char* array, std::size_t index);

/// Optional members with a default. They throw Error(where, ...) for the wrong type or length.
float read_number(const Json& object, const char* key, float fallback, const std::string& where);
std::size_t read_natural(const Json& object, const char* key, std::size_t fallback, const std::string& where);
bool read_flag(const Json& object, const char* key, bool fallback, const std::string& where);
std::string read_text(const Json& object, const char* key, const std::string& where);
template <int N>
glm::vec<N, float> read_vector(const Json& object, const char* key, const glm::vec<N, float>& fallback,
                               const std::string& where);

}  // namespace maquette::gltf
