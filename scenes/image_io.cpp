#include "scenes/image_io.h"

#include <stb/stb_image_write.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/image_rows.h"

namespace maquette {
namespace {

constexpr long long kMaxSide = 65536;
constexpr long long kMaxStreamedTexels = 1LL << 30;
constexpr long long kMaxTexels = 1LL << 27;  // 16384 x 8192: 2 GiB with alpha
constexpr std::array<unsigned char, 4> kExrMagic = {0x76, 0x2f, 0x31, 0x01};

std::array<unsigned char, 4> read_magic(const std::string& path) {
  std::error_code status;
  if (std::filesystem::is_directory(path, status))
    throw Error(path, "is a folder, not an image", "name a .exr or .hdr file");
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    const bool there = std::filesystem::exists(path, status);
    throw Error(path, there ? "cannot be read" : "does not exist", there ? "check its permissions" : "check the path");
  }
  std::array<unsigned char, 4> magic{};
  file.read(reinterpret_cast<char*>(magic.data()), magic.size());
  return magic;
}

std::uint8_t to_byte(float value) {
  // The comparison also sends NaN to 0.
  return value > 0.0f ? static_cast<std::uint8_t>(std::min(value, 1.0f) * 255.0f + 0.5f) : std::uint8_t{0};
}

}  // namespace

void check_image_size(const std::string& path, long long width, long long height) {
  const std::string size = std::to_string(width) + " x " + std::to_string(height);
  if (width < 1 || height < 1) throw Error(path, "the image has no texels (" + size + ")");
  if (width > kMaxSide || height > kMaxSide || width * height > kMaxStreamedTexels)
    throw Error(path, "an image of " + size + " is too large (at most 65,536 a side and 2^30 texels)",
                "make it smaller");
}

void stream_hdr_image(const std::string& path, HdrUse use, const HdrBegin& begin, const HdrRows& rows) {
  const std::array<unsigned char, 4> magic = read_magic(path);
  if (magic == kExrMagic) return stream_exr(path, use, begin, rows);
  if (magic[0] == '#' && magic[1] == '?') return stream_radiance(path, begin, rows);
  throw Error(path, "is neither an OpenEXR nor a Radiance HDR image", "use a .exr or .hdr file");
}

Image load_hdr_image(const std::string& path, std::vector<std::string>* warnings) {
  Image image;
  stream_hdr_image(
      path, HdrUse::picture,
      [&](const HdrInfo& info) {
        if (warnings) warnings->insert(warnings->end(), info.warnings.begin(), info.warnings.end());
        if (static_cast<long long>(info.width) * info.height > kMaxTexels)
          throw Error(path, "too large to load whole (at most 2^27 texels)", "make it smaller");
        image = Image(info.width, info.height, info.channels);
      },
      [&](int first_row, int row_count, const float* values) {
        const std::size_t row_floats = image.index(0, 1);
        std::copy_n(values, row_floats * static_cast<std::size_t>(row_count), &image.data[image.index(0, first_row)]);
      });
  return image;
}

void save_png(const std::string& path, const Image& image) {
  assert(image.width > 0 && image.height > 0 && image.channels >= 1 && image.channels <= 4);
  assert(image.data.size() == image.index(0, image.height));
  const int colors = image.channels < 3 ? 1 : 3;
  std::vector<std::uint8_t> bytes;
  bytes.reserve(image.data.size());
  for (std::size_t i = 0; i < image.data.size(); i += static_cast<std::size_t>(image.channels))
    std::transform(&image.data[i], &image.data[i] + colors, std::back_inserter(bytes), to_byte);
  std::vector<std::byte> png;
  const auto append = [](void* context, void* data, int size) {
    auto& target = *static_cast<std::vector<std::byte>*>(context);
    const auto* begin = static_cast<const std::byte*>(data);
    target.insert(target.end(), begin, begin + size);
  };
  if (!stbi_write_png_to_func(append, &png, image.width, image.height, colors, bytes.data(), image.width * colors))
    throw Error(path, "cannot encode the PNG", "make the image smaller");
  write_file_atomically(path, png);
}

}  // namespace maquette
