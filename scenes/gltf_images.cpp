#include <stb/stb_image.h>
#include <tbb/parallel_for.h>

#include <cstring>
#include <limits>
#include <optional>

#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/gltf_document.h"

namespace maquette::gltf {
namespace {

/// Limit of the texels of one image; larger images are invalid or not meant for a car.
constexpr std::int64_t kMaxTexels = std::int64_t{1} << 28;

/// Encoded bytes of image `index`; external and data: URIs are stored in `owned`.
Bytes encoded_bytes(const Document& document, const Json& json, std::size_t index, std::vector<std::byte>* owned) {
  const std::string where = at(document.path, element("images", index));
  if (json.contains("bufferView")) return view_bytes(document, json["bufferView"].get<std::size_t>());
  if (!json.contains("uri")) throw Error(where, "has neither uri nor bufferView");
  const auto& uri = json["uri"].get_ref<const std::string&>();
  *owned = uri.starts_with("data:") ? decode_data_uri(where, uri) : read_file(resolve_uri(document.path, uri));
  return *owned;
}

void decode(Bytes bytes, TextureImage* image) {
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) throw Error({}, "is larger than 2 GB");
  const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
  const int size = static_cast<int>(bytes.size());
  int width = 0, height = 0, channels = 0;
  if (stbi_info_from_memory(data, size, &width, &height, &channels) == 0) throw Error({}, "is not a PNG or JPEG image");
  if (std::int64_t{width} * height > kMaxTexels)
    throw Error({}, "has " + std::to_string(width) + " x " + std::to_string(height) + " texels, which is too large");
  stbi_uc* texels = stbi_load_from_memory(data, size, &width, &height, &channels, 4);
  if (texels == nullptr) throw Error({}, std::string("cannot be decoded: ") + stbi_failure_reason());
  image->width = width;
  image->height = height;
  image->rgba.assign(texels,
                     texels + std::size_t{4} * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  stbi_image_free(texels);
}

}  // namespace

void import_images(Document* document, Scene* scene) {
  const auto found = document->root.find("images");
  if (found == document->root.end()) return;
  scene->images.resize(found->size());
  std::vector<std::optional<std::string>> faults(found->size());
  tbb::parallel_for(std::size_t{0}, found->size(), [&](std::size_t i) {
    TextureImage& image = scene->images[i];
    const Json& json = (*found)[i];
    image.name = json.value("name", json.value("uri", std::string()));
    if (image.name.starts_with("data:")) image.name.clear();
    std::vector<std::byte> owned;
    try {
      decode(encoded_bytes(*document, json, i, &owned), &image);
    } catch (const Error& e) {
      faults[i] = e.what();
    }
  });
  for (std::size_t i = 0; i < faults.size(); ++i)
    if (faults[i]) document->warnings.add("its textures are left out: " + *faults[i], element("images", i));
}

}  // namespace maquette::gltf
