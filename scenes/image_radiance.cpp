// Radiance pictures (.hdr). Own reader, because stb_image reads a truncated file as black rows and needs the whole map
// in memory. Source: Ward 1991, "Real Pixels", Graphics Gems II; and the Radiance file format description (filefmts,
// "Picture File Format").
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/image_rows.h"

namespace maquette {
namespace {

using Bytes = std::span<const std::uint8_t>;
constexpr int kStripRows = 256;
constexpr std::size_t kMaxFileBytes = std::size_t{2} << 30;

Error damaged(const std::string& path, const std::string& what) {
  return Error(path, what, "copy or export the .hdr file again");
}

std::string_view next_line(const std::string& path, Bytes bytes, std::size_t& position) {
  const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(position);
  // Header lines are limited to this length.
  const auto limit = begin + std::min<std::ptrdiff_t>(4096, bytes.end() - begin);
  const auto end = std::find(begin, limit, std::uint8_t{'\n'});
  if (end == limit) throw damaged(path, "the Radiance header does not end");
  position += static_cast<std::size_t>(end - begin) + 1;
  return {reinterpret_cast<const char*>(&*begin), static_cast<std::size_t>(end - begin)};
}

/// Parses `-Y height +X width`, the only supported orientation.
HdrInfo parse_resolution(const std::string& path, std::string_view line) {
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  const auto number = [&](std::string_view prefix) {
    if (!line.starts_with(prefix))
      throw Error(path,
                  "unsupported orientation \"" + std::string(line.substr(0, 40)) + "\" (expected -Y height +X width)",
                  "export it the usual way up");
    line.remove_prefix(prefix.size());
    long long value = 0;
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), value);
    if (error != std::errc()) throw damaged(path, "the Radiance size line is not a pair of numbers");
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
    return value;
  };
  const long long height = number("-Y ");
  const long long width = number(" +X ");
  check_image_size(path, width, height);
  return {static_cast<int>(width), static_cast<int>(height), 3};
}

HdrInfo parse_header(const std::string& path, Bytes bytes, std::size_t& position) {
  for (;;) {
    const std::string_view line = next_line(path, bytes, position);
    if (line.empty() || line == "\r") break;
    if (line.starts_with("FORMAT=") && line.find("32-bit_rle_rgbe") == std::string_view::npos)
      throw Error(path, "the Radiance " + std::string(line.substr(0, 40)) + " is not 32-bit_rle_rgbe",
                  "convert it to RGBE");
  }
  return parse_resolution(path, next_line(path, bytes, position));
}

bool has_new_encoding(Bytes bytes, std::size_t position, int width) {
  return width >= 8 && width <= 0x7fff && position + 4 <= bytes.size() && bytes[position] == 2 &&
         bytes[position + 1] == 2 && ((bytes[position + 2] << 8) | bytes[position + 3]) == width;
}

/// Scans one row that starts at `position`, and writes it to `rgbe` ([4][width] planes for the new encoding, otherwise
/// interleaved) unless that is null. Returns the position after the row, or 0 when the data is damaged or ends early.
std::size_t scan_new_row(Bytes bytes, std::size_t position, int width, std::uint8_t* rgbe) {
  position += 4;
  const std::size_t row_bytes = 4 * static_cast<std::size_t>(width);
  for (std::size_t plane_begin = 0; plane_begin < row_bytes; plane_begin += static_cast<std::size_t>(width)) {
    std::size_t x = 0;
    while (x < static_cast<std::size_t>(width)) {
      if (position >= bytes.size()) return 0;
      const std::size_t code = bytes[position++];
      const bool run = code > 128;
      const std::size_t count = run ? code - 128 : code;
      const std::size_t needed = run ? 1 : count;
      if (count == 0 || x + count > static_cast<std::size_t>(width) || position + needed > bytes.size()) return 0;
      if (rgbe && run) std::fill_n(rgbe + plane_begin + x, count, bytes[position]);
      if (rgbe && !run) std::copy_n(bytes.data() + position, count, rgbe + plane_begin + x);
      position += needed;
      x += count;
    }
  }
  return position;
}

std::size_t scan_old_row(Bytes bytes, std::size_t position, int width, std::uint8_t* rgbe) {
  std::size_t x = 0;
  unsigned shift = 0;
  while (x < static_cast<std::size_t>(width)) {
    if (position + 4 > bytes.size()) return 0;
    const std::uint8_t* texel = bytes.data() + position;
    position += 4;
    if (texel[0] == 1 && texel[1] == 1 &&
        texel[2] == 1) {  // repeats the previous texel; consecutive codes are the higher digits of the count
      const std::size_t count = shift < 24 ? static_cast<std::size_t>(texel[3]) << shift : 0;
      if (x == 0 || count > static_cast<std::size_t>(width) - x) return 0;
      for (std::size_t i = 0; rgbe && i < count; ++i) std::copy_n(rgbe + 4 * (x - 1), 4, rgbe + 4 * (x + i));
      x += count;
      shift += 8;
    } else {
      if (rgbe) std::copy_n(texel, 4, rgbe + 4 * x);
      ++x;
      shift = 0;
    }
  }
  return position;
}

const std::array<float, 256>& exponent_scales() {
  static const std::array<float, 256> kScales = [] {
    std::array<float, 256> scales{};
    for (int e = 1; e < 256; ++e) scales[static_cast<std::size_t>(e)] = std::ldexp(1.0f, e - 136);
    return scales;
  }();
  return kScales;
}

void decode_row(Bytes bytes, std::size_t position, int width, float* rgb) {
  const auto count = static_cast<std::size_t>(width);
  std::vector<std::uint8_t> rgbe(4 * count);
  const bool planar = has_new_encoding(bytes, position, width);
  planar ? scan_new_row(bytes, position, width, rgbe.data()) : scan_old_row(bytes, position, width, rgbe.data());
  const std::size_t texel_stride = planar ? 1 : 4;
  const std::size_t channel_stride = planar ? count : 1;
  for (std::size_t x = 0; x < count; ++x) {
    const std::uint8_t* texel = rgbe.data() + x * texel_stride;
    const float scale = exponent_scales()[texel[3 * channel_stride]];
    for (std::size_t c = 0; c < 3; ++c) rgb[3 * x + c] = static_cast<float>(texel[c * channel_stride]) * scale;
  }
}

}  // namespace

void stream_radiance(const std::string& path, const HdrBegin& begin, const HdrRows& rows) {
  const std::vector<std::byte> file = read_file(path, kMaxFileBytes);
  const Bytes bytes(reinterpret_cast<const std::uint8_t*>(file.data()), file.size());
  std::size_t position = 0;
  const HdrInfo info = parse_header(path, bytes, position);

  // Rows are located first (so that nothing is allocated for missing data), then decoded on all cores.
  std::vector<std::size_t> row_begins;
  for (int y = 0; y < info.height; ++y) {
    row_begins.push_back(position);
    position = has_new_encoding(bytes, position, info.width) ? scan_new_row(bytes, position, info.width, nullptr)
                                                             : scan_old_row(bytes, position, info.width, nullptr);
    if (position == 0)
      throw damaged(path, "truncated or damaged: " + std::to_string(y) + " of " + std::to_string(info.height) +
                              " rows can be read");
  }
  begin(info);
  const std::size_t row_floats = 3 * static_cast<std::size_t>(info.width);
  std::vector<float> strip(row_floats * static_cast<std::size_t>(std::min(kStripRows, info.height)));
  for (int first = 0; first < info.height; first += kStripRows) {
    const int count = std::min(kStripRows, info.height - first);
    tbb::parallel_for(0, count, [&](int r) {
      decode_row(bytes, row_begins[static_cast<std::size_t>(first + r)], info.width,
                 strip.data() + static_cast<std::size_t>(r) * row_floats);
    });
    rows(first, count, strip.data());
  }
}

}  // namespace maquette
