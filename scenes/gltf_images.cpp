
#include <optional>
#include <string_view>

#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/gltf_document.h"
#include "scenes/parallel.h"
#include "scenes/texture_formats.h"

namespace maquette::gltf {
namespace {

/// What the textures make of one image.
struct ImageUse {
  bool preferred = false;   ///< a texture reads it first
  bool fallback = false;    ///< of a texture with EXT_texture_webp
  bool core = false;        ///< by a texture's own `source`
  bool replaceable = true;  ///< every texture that prefers it has a fallback
};

/// The result of reading one image.
struct ImageResult {
  std::optional<std::string> fault;
  std::vector<std::string> notes;
};

/// Encoded bytes of image `index`; external and data: URIs are stored in `owned`.
Bytes encoded_bytes(const Document& document, const Json& json, std::size_t index, std::vector<std::byte>* owned) {
  const std::string where = at(document.path, element("images", index));
  if (json.contains("bufferView")) return view_bytes(document, json["bufferView"].get<std::size_t>());
  if (!json.contains("uri")) throw Error(where, "has neither uri nor bufferView");
  const auto& uri = json["uri"].get_ref<const std::string&>();
  *owned = is_data_uri(uri) ? decode_data_uri(where, uri) : read_uri(document.path, uri);
  return *owned;
}

std::optional<std::size_t> source_of(const Json& object) {
  return object.contains("source") ? std::optional(object["source"].get<std::size_t>()) : std::nullopt;
}

std::optional<std::size_t> webp_source_of(const Json& texture) {
  const Json* extension = find_extension(texture, "EXT_texture_webp");
  return extension == nullptr ? std::nullopt : source_of(*extension);
}

std::vector<ImageUse> collect_uses(const Json& root, std::size_t count) {
  std::vector<ImageUse> uses(count);
  const auto textures = root.find("textures");
  if (textures == root.end()) return uses;
  for (const Json& texture : *textures) {
    const std::optional<std::size_t> core = source_of(texture), webp = webp_source_of(texture);
    if (core) uses[*core].core = true;
    if (core && webp) uses[*core].fallback = true;
    const std::optional<std::size_t> first = webp ? webp : core;
    if (!first) continue;
    uses[*first].preferred = true;
    if (!(core && webp)) uses[*first].replaceable = false;
  }
  return uses;
}

/// `image/png` and the like, for the formats that glTF knows.
std::string mime_type_of(Bytes bytes) {
  switch (texture_format(bytes)) {
    case TextureFormat::png:
      return "image/png";
    case TextureFormat::jpeg:
      return "image/jpeg";
    case TextureFormat::webp:
      return "image/webp";
    default:
      return {};
  }
}

/// What of an image says that it is of another type than `type`: its mimeType, its data URI; or null.
const char* contradicted(const Json& json, const std::string& type) {
  const auto mime = json.find("mimeType"), uri = json.find("uri");
  if (mime != json.end() && mime->is_string() && mime->get_ref<const std::string&>() != type) return "mimeType";
  if (uri == json.end() || json.contains("bufferView") || !is_data_uri(uri->get_ref<const std::string&>()))
    return nullptr;
  const std::string said = media_type(uri->get_ref<const std::string&>());
  return said.empty() || said == type ? nullptr : "data URI";
}

/// Reads image `i`; its bytes count, whatever its `mimeType` says.
ImageResult read_image(const Document& document, const Json& json, std::size_t i, const ImageUse& use,
                       TextureImage* image) {
  ImageResult result;
  std::vector<std::byte> owned;
  try {
    const Bytes bytes = encoded_bytes(document, json, i, &owned);
    decode_texture(bytes, image, &result.notes);
    if (use.core && texture_format(bytes) == TextureFormat::webp)
      result.notes.push_back("is a WebP image without the extension EXT_texture_webp; it is read");
    else if (const char* name = contradicted(json, mime_type_of(bytes)); name != nullptr)
      result.notes.push_back("is a " + texture_format_name(bytes) + " image, although its " + name + " says otherwise");
  } catch (const Error& e) {
    result.fault = e.what();
  }
  return result;
}

}  // namespace

std::optional<std::size_t> image_of_texture(const Json& texture, const Scene& scene) {
  const std::optional<std::size_t> core = source_of(texture), webp = webp_source_of(texture);
  return webp && (scene.images[*webp].width > 0 || !core) ? webp : core;
}

void import_images(Document* document, Scene* scene) {
  const auto found = document->root.find("images");
  if (found == document->root.end()) return;
  const std::vector<ImageUse> uses = collect_uses(document->root, found->size());
  scene->images.resize(found->size());
  std::vector<std::optional<ImageResult>> results(found->size());
  const auto read = [&](std::size_t i) {
    TextureImage& image = scene->images[i];
    const Json& json = (*found)[i];
    if (json.contains("name"))
      image.name = json["name"].get<std::string>();
    else if (json.contains("uri") && !is_data_uri(json["uri"].get_ref<const std::string&>()))
      image.name = json["uri"].get<std::string>();
    results[i] = read_image(*document, json, i, uses[i], &image);
  };
  // Images that only stand in for a WebP image are read when they have to.
  const auto waits = [&](std::size_t i) { return uses[i].fallback && !uses[i].preferred; };
  parallel_for(std::size_t{0}, found->size(), [&](std::size_t i) {
    if (!waits(i)) read(i);
  });
  if (const auto textures = document->root.find("textures"); textures != document->root.end())
    for (const Json& texture : *textures)
      if (const auto image = image_of_texture(texture, *scene); image && !results[*image]) read(*image);

  for (std::size_t i = 0; i < results.size(); ++i) {
    if (!results[i]) continue;
    const std::string where = element("images", i);
    if (results[i]->fault && uses[i].preferred && uses[i].replaceable)
      document->warnings.add("the other image of its textures is used: " + *results[i]->fault, where);
    else if (results[i]->fault)
      document->warnings.add("its textures are left out: " + *results[i]->fault, where);
    for (const std::string& note : results[i]->notes) document->warnings.add(note, where);
  }
}

}  // namespace maquette::gltf
