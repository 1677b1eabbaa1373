#include "scenes/texture_formats.h"

#include <stb/stb_image.h>
#include <turbojpeg.h>
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

namespace maquette {
namespace {

using Bytes = std::span<const std::byte>;

/// Limit of the texels of one image; larger images are invalid or not meant for a car.
constexpr std::int64_t kMaxTexels = std::int64_t{1} << 28;
constexpr std::size_t kPngSignature = 8;
constexpr std::size_t kChunkFrame = 12;  // length, name, checksum

std::string_view as_text(Bytes bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

std::size_t byte_at(Bytes bytes, std::size_t i) { return std::to_integer<std::size_t>(bytes[i]); }

std::size_t big_endian(Bytes bytes, std::size_t i, std::size_t count) {
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
void check_png(Bytes bytes) {
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

struct JpegFacts {
  std::size_t components = 0;
  bool adobe = false;
};

/// Walks over the segments up to the end of the image: decoders fill in what is missing.
JpegFacts check_jpeg(Bytes bytes) {
  JpegFacts facts;
  std::size_t i = 2;
  for (;;) {
    // Between segments lies a marker; in the data of a scan everything else is skipped until one comes.
    const void* found = i < bytes.size() ? std::memchr(bytes.data() + i, 0xff, bytes.size() - i) : nullptr;
    if (found == nullptr) throw cut_short();
    i = static_cast<std::size_t>(static_cast<const std::byte*>(found) - bytes.data()) + 1;
    if (i >= bytes.size()) throw cut_short();
    const std::size_t marker = byte_at(bytes, i);
    if (marker == 0xff) continue;  // fills up
    ++i;
    if (marker == 0xd9) return facts;
    if (marker <= 0x01 || (marker >= 0xd0 && marker <= 0xd8)) continue;  // without a segment
    if (bytes.size() - i < 2) throw cut_short();
    const std::size_t length = big_endian(bytes, i, 2);
    if (length > bytes.size() - i) throw cut_short();
    if (length < 2) throw Error({}, "is a damaged JPEG image", "copy or export it again");
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame && length >= 8) facts.components = byte_at(bytes, i + 7);
    if (marker == 0xee && as_text(bytes.subspan(i, length)).substr(2).starts_with("Adobe")) facts.adobe = true;
    i += length;
  }
}

void set_size(int width, int height, TextureImage* image) {
  if (std::int64_t{width} * height > kMaxTexels)
    throw Error({}, "has " + std::to_string(width) + " x " + std::to_string(height) + " texels, which is too large");
  image->width = width;
  image->height = height;
}

std::size_t value_count(const TextureImage& image) {
  return std::size_t{4} * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
}

/// Through libjpeg-turbo: stb_image reads Huffman tables that a damaged file does not define.
void decode_jpeg(Bytes bytes, const JpegFacts& facts, TextureImage* image, std::vector<std::string>* notes) {
  if (facts.components == 4 && !facts.adobe)
    throw Error({}, "is a JPEG image of four components without Adobe's marker", "export it as RGB");
  const std::unique_ptr<void, int (*)(tjhandle)> decoder(tjInitDecompress(), tjDestroy);
  if (decoder == nullptr) throw std::bad_alloc();
  // Bytes between the segments of the header hide nothing of the image; within its data they are damage.
  bool superfluous = false;
  const auto check = [&](int status, bool in_header) {
    if (status == 0) return;
    const std::string message = tjGetErrorStr2(decoder.get());
    const bool harmless = tjGetErrorCode(decoder.get()) == TJERR_WARNING && (in_header || superfluous) &&
                          message.find("extraneous bytes") != std::string::npos;
    if (!harmless) throw undecodable(message);
    superfluous = true;
  };
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  int width = 0, height = 0, subsampling = 0, colors = 0;
  check(tjDecompressHeader3(decoder.get(), data, bytes.size(), &width, &height, &subsampling, &colors), true);
  set_size(width, height, image);
  image->rgba.resize(value_count(*image));
  const bool cmyk = colors == TJCS_CMYK || colors == TJCS_YCCK;
  check(tjDecompress2(decoder.get(), data, bytes.size(), image->rgba.data(), width, 0, height,
                      cmyk ? TJPF_CMYK : TJPF_RGBA, TJFLAG_ACCURATEDCT | TJFLAG_LIMITSCANS),
        false);
  if (superfluous) notes->push_back("has superfluous bytes between the segments of its JPEG data");
  if (!cmyk) return;
  notes->push_back("is a CMYK image; its colours are converted without a profile");
  // Adobe stores 255 - C, 255 - M, 255 - Y and 255 - K.
  for (std::size_t i = 0; i < image->rgba.size(); i += 4) {
    std::uint8_t* texel = &image->rgba[i];
    for (int c = 0; c < 3; ++c) texel[c] = static_cast<std::uint8_t>((texel[c] * texel[3] + 127) / 255);
    texel[3] = 255;
  }
}

void decode_png(Bytes bytes, TextureImage* image) {
  const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
  const int size = static_cast<int>(bytes.size());
  int width = 0, height = 0, channels = 0;
  if (stbi_info_from_memory(data, size, &width, &height, &channels) == 0) throw undecodable(stbi_failure_reason());
  set_size(width, height, image);
  const auto load = [&](auto* texels, const auto& to_byte) {
    const std::unique_ptr<std::remove_pointer_t<decltype(texels)>, void (*)(void*)> owner(texels, stbi_image_free);
    if (texels == nullptr) throw undecodable(stbi_failure_reason());
    image->rgba.resize(value_count(*image));
    std::transform(texels, texels + image->rgba.size(), image->rgba.begin(), to_byte);
  };
  if (stbi_is_16_bit_from_memory(data, size) != 0) {
    // Rounded: stb_image's own conversion cuts off.
    load(stbi_load_16_from_memory(data, size, &width, &height, &channels, 4),
         [](stbi_us v) { return static_cast<std::uint8_t>((v * 255u + 32767u) / 65535u); });
  } else {
    load(stbi_load_from_memory(data, size, &width, &height, &channels, 4), [](stbi_uc v) { return v; });
  }
}

void decode_webp(Bytes bytes, TextureImage* image) {
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  WebPBitstreamFeatures features;
  const VP8StatusCode status = WebPGetFeatures(data, bytes.size(), &features);
  if (status == VP8_STATUS_NOT_ENOUGH_DATA) throw cut_short();
  if (status != VP8_STATUS_OK) throw Error({}, "is a damaged WebP image", "copy or export it again");
  if (features.has_animation != 0) throw Error({}, "is an animated WebP image", "export it as a still one");
  set_size(features.width, features.height, image);
  image->rgba.resize(value_count(*image));
  if (WebPDecodeRGBAInto(data, bytes.size(), image->rgba.data(), image->rgba.size(), 4 * image->width) == nullptr)
    throw Error({}, "is a damaged WebP image or cut short", "copy or export it again");
}

}  // namespace

TextureFormat texture_format(Bytes bytes) {
  const std::string_view text = as_text(bytes);
  if (text.starts_with("\x89PNG\r\n\x1a\n")) return TextureFormat::png;
  if (text.starts_with("\xff\xd8\xff")) return TextureFormat::jpeg;
  if (text.size() >= 12 && text.starts_with("RIFF") && text.substr(8, 4) == "WEBP") return TextureFormat::webp;
  return TextureFormat::unknown;
}

std::string texture_format_name(Bytes bytes) {
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

void decode_texture(Bytes bytes, TextureImage* image, std::vector<std::string>* notes) {
  if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) throw Error({}, "is larger than 2 GB");
  TextureImage decoded;
  switch (texture_format(bytes)) {
    case TextureFormat::png:
      check_png(bytes);
      decode_png(bytes, &decoded);
      break;
    case TextureFormat::jpeg:
      decode_jpeg(bytes, check_jpeg(bytes), &decoded, notes);
      break;
    case TextureFormat::webp:
      decode_webp(bytes, &decoded);
      break;
    case TextureFormat::unknown: {
      const std::string name = texture_format_name(bytes);
      throw Error({}, "is not a PNG or JPEG image" + (name.empty() ? "" : " but " + name));
    }
  }
  image->width = decoded.width;
  image->height = decoded.height;
  image->rgba = std::move(decoded.rgba);
}

}  // namespace maquette
