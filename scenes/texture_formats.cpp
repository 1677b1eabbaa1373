#include "scenes/texture_formats.h"

#include <stb/stb_image.h>
#include <webp/decode.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <string_view>

#include "scenes/error.h"
#include "scenes/texture_jpeg.h"

namespace maquette {
namespace {

using TextureBytes = std::span<const std::byte>;

/// Limit of the texels of one image (8192 x 8192); larger ones are invalid or not meant for a car.
constexpr std::int64_t kMostTextureTexels = std::int64_t{1} << 26;
constexpr std::size_t kPngSignature = 8;
constexpr std::size_t kChunkFrame = 12;  // length, name, checksum

std::string_view as_text(TextureBytes bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

std::size_t byte_at(TextureBytes bytes, std::size_t i) { return std::to_integer<std::size_t>(bytes[i]); }

std::size_t big_endian(TextureBytes bytes, std::size_t i, std::size_t count) {
  std::size_t value = 0;
  for (std::size_t k = 0; k < count; ++k) value = value << 8 | byte_at(bytes, i + k);
  return value;
}

/// What a decoder says; it may quote the file.
Error undecodable(std::string reason) {
  std::replace_if(
      reason.begin(), reason.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return Error({}, "cannot be decoded: " + reason, "copy or export it again");
}

Error cut_short() { return Error({}, "is cut short", "copy or export it again"); }

/// stb_image reads no checksums: damaged texels would be shown.
void check_png(TextureBytes bytes) {
  std::size_t position = kPngSignature;
  while (bytes.size() - position >= kChunkFrame) {
    const std::size_t length = big_endian(bytes, position, 4);
    const std::string_view name = as_text(bytes.subspan(position + 4, 4));
    if (length > bytes.size() - position - kChunkFrame) throw cut_short();
    const bool read = name == "IHDR" || name == "PLTE" || name == "tRNS" || name == "IDAT";
    const auto* content = reinterpret_cast<const Bytef*>(bytes.data() + position + 4);
    if (read && crc32_z(0, content, length + 4) != big_endian(bytes, position + 8 + length, 4))
      throw Error({}, "is damaged: the checksum of its " + std::string(name) + " chunk is wrong",
                  "copy or export it again");
    position += kChunkFrame + length;
    if (name == "IEND") return;
  }
  throw cut_short();
}

void check_size(std::int64_t width, std::int64_t height) {
  if (width * height > kMostTextureTexels)
    throw Error({}, "has " + std::to_string(width) + " x " + std::to_string(height) + " texels, more than 8192 x 8192",
                "make it smaller");
}

void set_size(int width, int height, TextureImage* image) {
  check_size(width, height);
  image->width = width;
  image->height = height;
  image->rgba.resize(std::size_t{4} * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
}

void decode_png(TextureBytes bytes, TextureImage* image) {
  const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
  const int size = static_cast<int>(bytes.size());
  int width = 0, height = 0, channels = 0;
  // The library has no word for what is too large. Source: PNG, third edition, Sec. 11.2.1 (IHDR).
  if (bytes.size() >= 24 && as_text(bytes).substr(12, 4) == "IHDR")
    check_size(static_cast<std::int64_t>(big_endian(bytes, 16, 4)),
               static_cast<std::int64_t>(big_endian(bytes, 20, 4)));
  if (stbi_info_from_memory(data, size, &width, &height, &channels) == 0) throw undecodable(stbi_failure_reason());
  set_size(width, height, image);
  const auto load = [&](auto* texels, auto* codes) {
    const std::unique_ptr<std::remove_pointer_t<decltype(texels)>, void (*)(void*)> owner(texels, stbi_image_free);
    if (texels == nullptr) throw undecodable(stbi_failure_reason());
    codes->assign(texels, texels + image->rgba.size());
  };
  if (stbi_is_16_bit_from_memory(data, size) != 0) {
    load(stbi_load_16_from_memory(data, size, &width, &height, &channels, 4), &image->rgba16);
    // Rounded: stb_image's own conversion cuts off.
    std::transform(image->rgba16.begin(), image->rgba16.end(), image->rgba.begin(),
                   [](std::uint16_t v) { return static_cast<std::uint8_t>((v * 255u + 32767u) / 65535u); });
  } else {
    load(stbi_load_from_memory(data, size, &width, &height, &channels, 4), &image->rgba);
  }
}

void decode_webp(TextureBytes bytes, TextureImage* image) {
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  WebPBitstreamFeatures features;
  const VP8StatusCode status = WebPGetFeatures(data, bytes.size(), &features);
  if (status == VP8_STATUS_NOT_ENOUGH_DATA) throw cut_short();
  if (status != VP8_STATUS_OK) throw Error({}, "is a damaged WebP image", "copy or export it again");
  if (features.has_animation != 0) throw Error({}, "is an animated WebP image", "export it as a still one");
  set_size(features.width, features.height, image);
  if (WebPDecodeRGBAInto(data, bytes.size(), image->rgba.data(), image->rgba.size(), 4 * image->width) == nullptr)
    throw Error({}, "is a damaged WebP image or cut short", "copy or export it again");
}

}  // namespace

TextureFormat texture_format(TextureBytes bytes) {
  const std::string_view text = as_text(bytes);
  if (text.starts_with("\x89PNG\r\n\x1a\n")) return TextureFormat::png;
  if (text.starts_with("\xff\xd8\xff")) return TextureFormat::jpeg;
  if (text.size() >= 12 && text.starts_with("RIFF") && text.substr(8, 4) == "WEBP") return TextureFormat::webp;
  return TextureFormat::unknown;
}

std::string texture_format_name(TextureBytes bytes) {
  switch (texture_format(bytes)) {
    case TextureFormat::png:
      return "PNG";
    case TextureFormat::jpeg:
      return "JPEG";
    case TextureFormat::webp:
      return "WebP";
    default:
      break;
  }
  constexpr std::array<std::array<std::string_view, 2>, 7> kOthers = {{{"\xabKTX 20", "KTX2"},
                                                                       {"GIF8", "GIF"},
                                                                       {"BM", "BMP"},
                                                                       {"DDS ", "DDS"},
                                                                       {"8BPS", "PSD"},
                                                                       {"#?", "Radiance"},
                                                                       {"\x76\x2f\x31\x01", "OpenEXR"}}};
  for (const auto& [magic, name] : kOthers)
    if (as_text(bytes).starts_with(magic)) return std::string(name);
  return {};
}

glm::ivec2 texture_size(TextureBytes bytes) {
  const auto limit = static_cast<std::size_t>(std::numeric_limits<int>::max());
  if (bytes.size() > limit) return {};
  int width = 0, height = 0, channels = 0;
  if (texture_format(bytes) == TextureFormat::webp) {
    WebPBitstreamFeatures features;
    const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
    if (WebPGetFeatures(data, bytes.size(), &features) != VP8_STATUS_OK) return {};
    return {features.width, features.height};
  }
  const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
  if (stbi_info_from_memory(data, static_cast<int>(bytes.size()), &width, &height, &channels) == 0) return {};
  if (std::int64_t{width} * height > kMostTextureTexels) return {};  // is not decoded
  return {width, height};
}

void decode_texture(TextureBytes bytes, TextureImage* image, std::vector<std::string>* notes) {
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) throw Error({}, "is larger than 2 GB");
  TextureImage decoded;
  switch (texture_format(bytes)) {
    case TextureFormat::png:
      check_png(bytes);
      decode_png(bytes, &decoded);
      break;
    case TextureFormat::jpeg:
      decode_jpeg(
          bytes, [&](int width, int height) { set_size(width, height, &decoded); }, &decoded, notes);
      break;
    case TextureFormat::webp:
      decode_webp(bytes, &decoded);
      break;
    case TextureFormat::unknown: {
      const std::string name = texture_format_name(bytes);
      throw Error({}, "is not a PNG, JPEG or WebP image" + (name.empty() ? "" : " but " + name));
    }
  }
  image->width = decoded.width;
  image->height = decoded.height;
  image->rgba = std::move(decoded.rgba);
  image->rgba16 = std::move(decoded.rgba16);
}

}  // namespace maquette
