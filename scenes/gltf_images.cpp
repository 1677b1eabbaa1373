#include <algorithm>
#include <functional>
#include <optional>
#include <set>
#include <string_view>

#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/gltf_document.h"
#include "scenes/parallel.h"
#include "scenes/texture_budget.h"
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

/// One image as it is in the file, and what came of reading it.
struct EncodedImage {
  std::vector<std::byte> owned;  ///< of external and data: URIs
  Bytes bytes;
  glm::ivec2 size{0};  ///< as its header says
  int halvings = 0;
  bool read = false;
  std::optional<std::string> fault;
  std::vector<std::string> notes;
};

EncodedImage find_bytes(const Document& document, const Json& json, std::size_t index) {
  EncodedImage image;
  try {
    const std::string where = at(document.path, element("images", index));
    if (json.contains("bufferView")) {
      image.bytes = view_bytes(document, json["bufferView"].get<std::size_t>());
    } else if (json.contains("uri")) {
      const auto& uri = json["uri"].get_ref<const std::string&>();
      image.owned = is_data_uri(uri) ? decode_data_uri(where, uri) : read_uri(document.path, uri);
      image.bytes = image.owned;
    } else {
      throw Error(where, "has neither uri nor bufferView");
    }
    image.size = texture_size(image.bytes);
  } catch (const Error& e) {
    image.fault = e.what();
  }
  return image;
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

/// [image] whether a texture that is stored in sRGB reads it.
std::vector<bool> find_colours(const Json& root, std::size_t count) {
  std::vector<bool> colours(count, false);
  const auto textures = root.find("textures");
  if (textures == root.end()) return colours;
  const auto mark = [&](const Json& reference) {
    const auto index = reference.find("index");
    if (index == reference.end() || !index->is_number_unsigned() || index->get<std::size_t>() >= textures->size())
      return;
    const Json& texture = (*textures)[index->get<std::size_t>()];
    for (const auto& source : {source_of(texture), webp_source_of(texture)})
      if (source) colours[*source] = true;
  };
  const std::function<void(const Json&)> visit = [&](const Json& value) {
    if (!value.is_object()) return;
    for (auto member = value.begin(); member != value.end(); ++member) {
      const bool colour = member.key().ends_with("ColorTexture") || member.key() == "emissiveTexture";
      if (colour && member.value().is_object()) mark(member.value());
      if (member.key() != "extras") visit(member.value());
    }
  };
  if (const auto materials = root.find("materials"); materials != root.end())
    for (const Json& material : *materials) visit(material);
  return colours;
}

/// Reads an image; its bytes count, whatever its `mimeType` says.
void read_image(const Json& json, const ImageUse& use, bool colour, EncodedImage* encoded, TextureImage* image) {
  encoded->read = true;
  if (encoded->fault) return;
  const Bytes bytes = encoded->bytes;
  std::vector<std::string>& notes = encoded->notes;
  try {
    decode_texture(bytes, image, &notes);
    halve_image(image, encoded->halvings, colour);
    if (use.core && texture_format(bytes) == TextureFormat::webp)
      notes.push_back("is a WebP image without the extension EXT_texture_webp; it is read");
    else if (const char* name = contradicted(json, mime_type_of(bytes)); name != nullptr)
      notes.push_back("is a " + texture_format_name(bytes) + " image, although its " + name + " says otherwise");
  } catch (const Error& e) {
    encoded->fault = e.what();
  }
  encoded->owned = {};
}

/// Calls read(i) for each `i` of `wanted`, on all cores, as many at a time as the memory for decoding is for.
void read_in_batches(const std::vector<std::size_t>& wanted, const std::vector<EncodedImage>& images,
                     const std::function<void(std::size_t)>& read) {
  constexpr std::size_t kBatchTexels = std::size_t{1} << 26;
  for (std::size_t begin = 0, end = 0; begin < wanted.size(); begin = end) {
    for (std::size_t texels = 0; end < wanted.size(); ++end) {
      texels += texels_of(images[wanted[end]].size);
      if (texels > kBatchTexels && end > begin) break;
    }
    parallel_for(begin, end, [&](std::size_t k) { read(wanted[k]); });
  }
}

/// Decides how often each of the images that are read is halved, and warns where one is.
void keep_to_budget(const std::vector<std::size_t>& wanted, std::vector<EncodedImage>* images, Warnings* warnings) {
  std::vector<glm::ivec2> sizes;
  std::size_t bytes = 0, texels = 0;
  std::set<const std::byte*> counted;  // images may share their bytes
  for (const std::size_t i : wanted) {
    sizes.push_back((*images)[i].size);
    if (counted.insert((*images)[i].bytes.data()).second) bytes += (*images)[i].bytes.size();
    texels += texels_of(sizes.back());
  }
  const std::vector<int> halvings = halvings_within(sizes, most_texels(bytes));
  for (std::size_t k = 0; k < wanted.size(); ++k) (*images)[wanted[k]].halvings = halvings[k];
  const auto halved = std::count_if(halvings.begin(), halvings.end(), [](int times) { return times > 0; });
  if (halved == 0) return;
  const auto millions = [](std::size_t count) { return std::to_string((count + 500'000) / 1'000'000) + " million"; };
  warnings->add("its images have " + millions(texels) + " texels together, " + millions(most_texels(bytes)) +
                " are kept of images of so many bytes: " + std::to_string(halved) +
                " are read at half their width or less");
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
  const std::vector<bool> colours = find_colours(document->root, found->size());
  scene->images.resize(found->size());
  std::vector<EncodedImage> images(found->size());
  std::vector<std::size_t> wanted;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Json& json = (*found)[i];
    if (json.contains("name"))
      scene->images[i].name = json["name"].get<std::string>();
    else if (json.contains("uri") && !is_data_uri(json["uri"].get_ref<const std::string&>()))
      scene->images[i].name = json["uri"].get<std::string>();
    // Images that only stand in for a WebP image are read when they have to.
    if (!uses[i].fallback || uses[i].preferred) wanted.push_back(i);
  }
  parallel_for(std::size_t{0}, wanted.size(),
               [&](std::size_t k) { images[wanted[k]] = find_bytes(*document, (*found)[wanted[k]], wanted[k]); });
  keep_to_budget(wanted, &images, &document->warnings);
  const auto read = [&](std::size_t i) { read_image((*found)[i], uses[i], colours[i], &images[i], &scene->images[i]); };
  read_in_batches(wanted, images, read);
  if (const auto textures = document->root.find("textures"); textures != document->root.end())
    for (const Json& texture : *textures)
      if (const auto image = image_of_texture(texture, *scene); image && !images[*image].read) {
        images[*image] = find_bytes(*document, (*found)[*image], *image);
        keep_to_budget({*image}, &images, &document->warnings);
        read(*image);
      }

  for (std::size_t i = 0; i < images.size(); ++i) {
    if (!images[i].read) continue;
    const std::string where = element("images", i);
    if (images[i].fault && uses[i].preferred && uses[i].replaceable)
      document->warnings.add("the other image of its textures is used: " + *images[i].fault, where);
    else if (images[i].fault)
      document->warnings.add("its textures are left out: " + *images[i].fault, where);
    for (const std::string& note : images[i].notes) document->warnings.add(note, where);
  }
}

}  // namespace maquette::gltf
