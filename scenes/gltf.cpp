#include <algorithm>
#include <new>
#include <stdexcept>

#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/gltf_document.h"

namespace maquette::gltf {
namespace {

/// The part of the file that tinygltf parses: the structure. We read buffers and images ourselves (in place, in
/// parallel), and extensions and extras stay JSON. tinygltf requires a buffer view for indices, which Draco primitives
/// need not have.
Json core_of(const Json& root) {
  Json core = Json::object();
  for (const char* key :
       {"asset", "bufferViews", "accessors", "meshes", "nodes", "scenes", "scene", "textures", "samplers", "cameras"}) {
    const auto found = root.find(key);
    if (found == root.end()) continue;
    core[key] = *found;
    if (!core[key].is_array()) continue;
    for (Json& item : core[key]) {
      item.erase("extensions");
      item.erase("extras");
    }
  }
  if (!core.contains("meshes")) return core;
  for (Json& mesh : core["meshes"]) {
    for (Json& primitive : mesh["primitives"]) {
      primitive.erase("extensions");
      primitive.erase("extras");
      primitive.erase("indices");
      primitive.erase("targets");
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
  std::replace(error.begin(), error.end(), '\n', ' ');
  if (!parsed) throw Error(document->path, "cannot be read: " + error, "export it again");
}

void open_buffers(Document* document, Bytes binary, bool is_binary) {
  const auto found = document->root.find("buffers");
  if (found == document->root.end()) return;
  document->owned_buffers.resize(found->size());
  document->buffers.resize(found->size());
  for (std::size_t i = 0; i < found->size(); ++i) {
    const Json& buffer = (*found)[i];
    const std::string where = at(document->path, element("buffers", i));
    const auto size = buffer["byteLength"].get<std::size_t>();
    Bytes bytes;
    if (!buffer.contains("uri")) {
      if (i != 0 || !is_binary) throw Error(where, "has no uri", "the file is damaged; export it again");
      bytes = binary;
    } else {
      const auto& uri = buffer["uri"].get_ref<const std::string&>();
      try {
        document->owned_buffers[i] =
            uri.starts_with("data:") ? decode_data_uri(where, uri) : read_file(resolve_uri(document->path, uri));
      } catch (const Error& e) {
        if (uri.starts_with("data:")) throw;
        throw Error(where, e.what(), "put the file beside the glTF");
      }
      bytes = document->owned_buffers[i];
    }
    if (bytes.size() < size)
      throw Error(where, "has " + std::to_string(bytes.size()) + " bytes, byteLength promises " + std::to_string(size),
                  "the file is truncated; copy or export it again");
    document->buffers[i] = bytes.first(size);
  }
}

void warn_of_the_rest(Document* document) {
  const Json& root = document->root;
  const auto count = [&root](const char* key) {
    const auto found = root.find(key);
    return found != root.end() && found->is_array() ? found->size() : 0;
  };
  if (count("animations") > 0)
    document->warnings.add(std::to_string(count("animations")) + " animations are not played: the scene stands still");
  if (count("skins") > 0)
    document->warnings.add(std::to_string(count("skins")) + " skins are ignored: meshes keep their bind pose");
  if (count("scenes") > 1)
    document->warnings.add("only the default of " + std::to_string(count("scenes")) + " scenes is shown");
}

}  // namespace

Document open_document(const std::string& path) {
  Document document;
  document.path = path;
  document.file = read_file(path);
  const Container container = split_container(path, document.file, &document.warnings);
  document.root = parse_checked(path, container.json);
  check_extensions(path, document.root, &document.warnings);
  open_buffers(&document, container.binary, container.is_binary);
  parse_core(&document);
  warn_of_the_rest(&document);
  return document;
}

}  // namespace maquette::gltf

namespace maquette {

namespace {

Scene import_file(const std::string& path) {
  gltf::Document document = gltf::open_document(path);
  Scene scene;
  scene.name = path;
  gltf::import_materials(&document, &scene);
  gltf::import_meshes(&document, &scene);
  gltf::import_cages(document, &scene);
  gltf::import_patches(document, &scene);
  gltf::import_nodes(&document, &scene);
  if (count_triangles(scene) == 0 && scene.patches.empty())
    document.warnings.add("there is nothing to see: the default scene has no triangles");
  scene.warnings = document.warnings.lines();
  return scene;
}

}  // namespace

Scene load_gltf(const std::string& path) {
  const Error too_large(path, "needs more memory than there is", "load a smaller model");
  try {
    return import_file(path);
  } catch (const std::bad_alloc&) {
    throw too_large;
  } catch (const std::length_error&) {
    throw too_large;
  }
}

}  // namespace maquette
