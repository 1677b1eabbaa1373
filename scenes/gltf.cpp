#include <filesystem>
#include <map>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/gltf_document.h"

namespace maquette::gltf {
namespace {

/// The part of the file that tinygltf parses: members that have been checked. We read buffers, images, materials,
/// meshes and cameras ourselves (in place, in parallel), and extensions and extras stay JSON.
Json core_of(const Json& root) {
  static const std::map<std::string, std::vector<const char*>> kMembers = {
      {"bufferViews", {"buffer", "byteOffset", "byteLength", "byteStride"}},
      {"accessors", {"bufferView", "byteOffset", "componentType", "count", "type", "normalized", "sparse"}},
      {"nodes", {"name", "mesh", "children", "matrix", "translation", "rotation", "scale"}},
      {"scenes", {"nodes"}},
      {"textures", {}}};
  Json core = {{"asset", {{"version", "2.0"}}}};
  if (root.contains("scene")) core["scene"] = root["scene"];
  for (const auto& [array, members] : kMembers) {
    const auto found = root.find(array);
    if (found == root.end()) continue;
    core[array] = Json::array();
    for (const Json& item : *found) {
      Json& out = core[array].emplace_back(Json::object());
      for (const char* member : members)
        if (item.contains(member)) out[member] = item[member];
    }
  }
  return core;
}

void parse_core(Document* document) {
  const std::string text = core_of(document->root).dump();
  tinygltf::TinyGLTF parser;
  std::string error, warning;
  bool parsed = false;
  try {
    parsed = parser.LoadASCIIFromString(&document->model, &error, &warning, text.data(),
                                        static_cast<unsigned int>(text.size()), "", tinygltf::REQUIRE_VERSION);
  } catch (const std::exception& e) {
    error = e.what();
  }
  if (!parsed) throw Error(document->path, "cannot be read: " + error, "export it again");
}

/// Bytes of a buffer: in the file itself, in its URI or beside the file. Without either it stays empty: extensions may
/// have use for it.
Bytes open_buffer(Document* document, std::size_t index, const Json& buffer, const Container& container) {
  const std::string where = at(document->path, element("buffers", index));
  std::vector<std::byte>& owned = document->owned_buffers[index];
  const auto found = buffer.find("uri");
  if (is_fallback(buffer)) return {};
  if (found == buffer.end()) return index == 0 && container.is_binary ? container.binary : Bytes();
  const auto& uri = found->get_ref<const std::string&>();
  if (is_data_uri(uri)) {
    owned = decode_data_uri(where, uri);
    const std::string type = media_type(uri);
    if (!type.empty() && type != "application/octet-stream" && type != "application/gltf-buffer")
      document->warnings.add("its data URI says that it is something else than a buffer; it is read",
                             element("buffers", index));
    return owned;
  }
  try {
    owned = read_uri(document->path, uri);
  } catch (const Error& e) {
    throw Error(where, e.what(), "put the file beside the glTF");
  }
  return owned;
}

void open_buffers(Document* document, const Container& container) {
  const auto found = document->root.find("buffers");
  if (found == document->root.end()) return;
  document->owned_buffers.resize(found->size());
  document->buffers.resize(found->size());
  for (std::size_t i = 0; i < found->size(); ++i) {
    const Json& buffer = (*found)[i];
    try {
      const Bytes bytes = open_buffer(document, i, buffer, container);
      if (bytes.data() == nullptr && (!buffer.contains("uri") || is_fallback(buffer))) continue;
      const auto size = buffer["byteLength"].get<std::size_t>();
      if (bytes.size() < size)
        throw Error(at(document->path, element("buffers", i)),
                    "has " + std::to_string(bytes.size()) + " bytes, byteLength promises " + std::to_string(size),
                    "the file is truncated; copy or export it again");
      document->buffers[i] = bytes.first(size);
    } catch (const Error& e) {
      document->buffer_faults.emplace(i, e);
    }
  }
}

}  // namespace

/// Buffers that could not be read and that nothing needed: else the import has thrown the fault.
void warn_of_buffers(Document* document) {
  for (const auto& [index, fault] : document->buffer_faults) {
    std::string line = fault.what();
    const std::string where = at(document->path, element("buffers", index)) + ": ";
    if (line.starts_with(where)) line = line.substr(where.size());
    document->warnings.add(line + "; nothing needs it", element("buffers", index));
  }
}

Document open_document(const std::string& path, const std::string& scene) {
  Document document;
  document.path = path;
  document.file = read_file(path);
  const Container container = split_container(path, document.file, &document.warnings);
  document.root = parse_checked(path, container.json);
  check_extensions(path, document.root, &document.warnings);
  open_buffers(&document, container);
  parse_core(&document);
  decode_views(&document);
  import_tree(&document, scene);
  find_mesh_uses(&document);
  return document;
}

}  // namespace maquette::gltf

namespace maquette {

namespace {

Scene import_file(const std::string& path, const std::string& scene_name) {
  gltf::Document document = gltf::open_document(path, scene_name);
  Scene scene;
  scene.name = path;
  gltf::import_materials(&document, &scene);
  gltf::import_meshes(&document, &scene);
  gltf::import_cages(document, &scene);
  gltf::import_patches(document, &scene);
  gltf::import_nodes(&document, &scene);
  gltf::warn_of_buffers(&document);
  if (count_triangles(scene) == 0 && scene.patches.empty())
    document.warnings.add("there is nothing to see: the scene has no triangles");
  const std::string folder = std::filesystem::path(path).parent_path().string();
  for (const std::string& line : document.warnings.lines()) scene.warnings.push_back(gltf::plain_line(line, folder));
  return scene;
}

}  // namespace

Scene load_gltf(const std::string& path, const std::string& scene) {
  const Error too_large(path, "needs more memory than there is", "load a smaller model");
  try {
    return import_file(path, scene);
  } catch (const UsageError& e) {
    throw UsageError({}, gltf::plain_line(e.what(), std::filesystem::path(path).parent_path().string()));
  } catch (const Error& e) {
    throw Error({}, gltf::plain_line(e.what(), std::filesystem::path(path).parent_path().string()));
  } catch (const std::bad_alloc&) {
    throw too_large;
  } catch (const std::length_error&) {
    throw too_large;
  }
}

}  // namespace maquette
