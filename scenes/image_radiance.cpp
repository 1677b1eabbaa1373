// Radiance pictures (.hdr). Own reader, because stb_image reads a truncated file as black rows and needs the whole map
// in memory. Source: Ward 1991, "Real Pixels", Graphics Gems II; and the Radiance file format description (filefmts,
// "Picture File Format").

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/image_color.h"
#include "scenes/image_rows.h"
#include "scenes/parallel.h"

namespace maquette {
namespace {

using RadianceBytes = std::span<const std::uint8_t>;
constexpr int kRadianceRows = 256;
constexpr std::size_t kMaxFileBytes = std::size_t{2} << 30;
constexpr std::size_t kMaxTurnedTexels = std::size_t{1} << 28;

Error damaged(const std::string& path, const std::string& what) {
  return Error(path, what, "copy or export the .hdr file again");
}

std::string_view next_line(const std::string& path, RadianceBytes bytes, std::size_t& position) {
  const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(position);
  // Header lines are limited to this length.
  const auto limit = begin + std::min<std::ptrdiff_t>(4096, bytes.end() - begin);
  const auto end = std::find(begin, limit, std::uint8_t{'\n'});
  if (end == limit) throw damaged(path, "the Radiance header does not end");
  position += static_cast<std::size_t>(end - begin) + 1;
  return {reinterpret_cast<const char*>(&*begin), static_cast<std::size_t>(end - begin)};
}

/// Directions of the picture's two axes; the file's lines follow the first.
struct Orientation {
  int line_count = 0;
  int line_length = 0;
  bool lines_are_columns = false;  ///< X comes first
  bool from_bottom = false;        ///< +Y
  bool from_right = false;         ///< -X
};

/// What the header says about the values.
struct Header {
  Orientation orientation;
  glm::dvec3 gain{1.0};  ///< that has been applied to the picture
  std::optional<Primaries> primaries;
  std::vector<std::string> warnings;
};

/// Parses e.g. `-Y height +X width`.
Orientation parse_resolution(const std::string& path, std::string_view line) {
  const std::string shown(line.substr(0, 40));
  Orientation result;
  std::array<char, 2> axes{};
  std::array<long long, 2> sizes{};
  for (std::size_t k = 0; k < 2; ++k) {
    if (k == 1 && line.starts_with(' ')) line.remove_prefix(1);
    const bool known = line.size() > 3 && (line[0] == '-' || line[0] == '+') && (line[1] == 'X' || line[1] == 'Y') &&
                       line[2] == ' ' && (k == 0 || line[1] != axes[0]);
    if (!known) throw damaged(path, "the Radiance size line is \"" + shown + "\", expected e.g. -Y height +X width");
    axes[k] = line[1];
    if (line[1] == 'Y' && line[0] == '+') result.from_bottom = true;
    if (line[1] == 'X' && line[0] == '-') result.from_right = true;
    line.remove_prefix(3);
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), sizes[k]);
    if (error != std::errc())
      throw damaged(path, "the Radiance size line is \"" + shown + "\", expected e.g. -Y height +X width");
    line.remove_prefix(static_cast<std::size_t>(end - line.data()));
  }
  check_image_size(path, sizes[1], sizes[0]);
  result.lines_are_columns = axes[0] == 'X';
  result.line_count = static_cast<int>(sizes[0]);
  result.line_length = static_cast<int>(sizes[1]);
  return result;
}

/// Up to `limit` numbers, separated by white space.
std::vector<double> parse_numbers(std::string_view text, std::size_t limit) {
  std::vector<double> values;
  while (values.size() < limit) {
    const std::size_t begin = text.find_first_not_of(" \t+");
    if (begin == std::string_view::npos) break;
    text.remove_prefix(begin);
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc()) break;
    values.push_back(value);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  }
  return values;
}

/// EXPOSURE and COLORCORR: factors that the picture has been multiplied by; several lines are cumulative.
void read_gain(std::string_view name, std::string_view text, std::size_t count, Header* header) {
  const std::vector<double> values = parse_numbers(text, count);
  glm::dvec3 gain = header->gain;
  for (std::size_t c = 0; c < 3 && values.size() == count; ++c) gain[static_cast<int>(c)] *= values[count == 1 ? 0 : c];
  // Also false for NaN.
  const auto fine = [](double g) { return g >= 1e-30 && g <= 1e30; };
  if (values.size() == count && fine(gain.x) && fine(gain.y) && fine(gain.z))
    header->gain = gain;
  else
    header->warnings.push_back("a line " + std::string(name) + " without positive numbers is ignored");
}

void read_primaries(std::string_view text, Header* header) {
  const std::vector<double> v = parse_numbers(text, 8);
  const Primaries primaries =
      v.size() == 8 ? Primaries{{v[0], v[1]}, {v[2], v[3]}, {v[4], v[5]}, {v[6], v[7]}} : Primaries{};
  if (v.size() == 8 && xyz_from_rgb(primaries))
    header->primaries = primaries;
  else
    header->warnings.push_back("its PRIMARIES describe no colour space; its colours are taken as Rec.709");
}

/// Source: Radiance file format description, "Picture File Format". Lines that begin with a tab tell of the pictures
/// that this one was made of, and do not hold for it.
void read_variable(const std::string& path, std::string_view line, Header* header) {
  const std::size_t equals = line.find('=');
  if (equals == std::string_view::npos) return;
  const std::string_view name = line.substr(0, equals), text = line.substr(equals + 1);
  if (name == "FORMAT") {
    if (text.find("32-bit_rle_rgbe") == std::string_view::npos)
      throw Error(path, "the Radiance " + std::string(line.substr(0, 40)) + " is not 32-bit_rle_rgbe",
                  "convert it to RGBE");
  } else if (name == "EXPOSURE") {
    read_gain(name, text, 1, header);
  } else if (name == "COLORCORR") {
    read_gain(name, text, 3, header);
  } else if (name == "PRIMARIES") {
    read_primaries(text, header);
  } else if (name == "GAMMA") {
    // Not of the format: RGBE is linear, and most readers do not know the line.
    if (parse_numbers(text, 1) != std::vector<double>{1.0})
      header->warnings.push_back("the line " + std::string(line.substr(0, 40)) +
                                 " is ignored: Radiance pictures are linear");
  }
}

Header parse_header(const std::string& path, RadianceBytes bytes, std::size_t& position) {
  Header header;
  const auto next = [&] {
    std::string_view line = next_line(path, bytes, position);
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  };
  for (std::string_view line = next(); !line.empty(); line = next()) read_variable(path, line, &header);
  header.orientation = parse_resolution(path, next());
  return header;
}

/// Rec.709 of the stored values; nothing when they are that.
std::optional<glm::mat3> conversion_of(const Header& header) {
  const bool converts = header.primaries && !is_rec709(*header.primaries);
  if (!converts && header.gain == glm::dvec3(1.0)) return std::nullopt;
  const glm::dmat3 rec709 = converts ? rec709_from_rgb(*header.primaries) : glm::dmat3(1.0);
  // The gain was applied to the values that are stored, so it is taken away first.
  return glm::mat3(rec709[0] / header.gain.x, rec709[1] / header.gain.y, rec709[2] / header.gain.z);
}

bool has_new_encoding(RadianceBytes bytes, std::size_t position, int width) {
  return width >= 8 && width <= 0x7fff && position + 4 <= bytes.size() && bytes[position] == 2 &&
         bytes[position + 1] == 2 && ((bytes[position + 2] << 8) | bytes[position + 3]) == width;
}

/// Scans one row that starts at `position`, and writes it to `rgbe` ([4][width] planes for the new encoding, otherwise
/// interleaved) unless that is null. Returns the position after the row, or 0 when the data is damaged or ends early.
std::size_t scan_new_row(RadianceBytes bytes, std::size_t position, int width, std::uint8_t* rgbe) {
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

std::size_t scan_old_row(RadianceBytes bytes, std::size_t position, int width, std::uint8_t* rgbe) {
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

using Rgbe = std::array<std::uint8_t, 4>;

/// Calls put(i, texel) for each texel of the line that starts at `position`.
template <class Put>
void decode_line(RadianceBytes bytes, std::size_t position, int length, const Put& put) {
  const auto count = static_cast<std::size_t>(length);
  std::vector<std::uint8_t> rgbe(4 * count);
  const bool planar = has_new_encoding(bytes, position, length);
  planar ? scan_new_row(bytes, position, length, rgbe.data()) : scan_old_row(bytes, position, length, rgbe.data());
  const std::size_t texel_stride = planar ? 1 : 4;
  const std::size_t channel_stride = planar ? count : 1;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* texel = rgbe.data() + i * texel_stride;
    put(i, Rgbe{texel[0], texel[channel_stride], texel[2 * channel_stride], texel[3 * channel_stride]});
  }
}

void to_float(const Rgbe& texel, float* rgb) {
  const float scale = exponent_scales()[texel[3]];
  for (std::size_t c = 0; c < 3; ++c) rgb[c] = static_cast<float>(texel[c]) * scale;
}

/// The lines of one file, turned into rows from the top and from the left.
class RowSource {
 public:
  RowSource(const std::string& path, RadianceBytes bytes, std::size_t position, const Orientation& orientation)
      : bytes_(bytes), orientation_(orientation) {
    // Lines are located first, so that nothing is allocated for missing data.
    for (int i = 0; i < orientation.line_count; ++i) {
      begins_.push_back(position);
      position = has_new_encoding(bytes, position, orientation.line_length)
                     ? scan_new_row(bytes, position, orientation.line_length, nullptr)
                     : scan_old_row(bytes, position, orientation.line_length, nullptr);
      if (position == 0)
        throw damaged(path, "truncated or damaged: " + std::to_string(i) + " of " +
                                std::to_string(orientation.line_count) + " rows can be read");
    }
    const std::size_t texels =
        static_cast<std::size_t>(orientation.line_count) * static_cast<std::size_t>(orientation.line_length);
    if (orientation.lines_are_columns && texels > kMaxTurnedTexels)
      throw Error(path, "a picture stored in columns is too large (at most 2^28 texels)", "store it in rows");
  }

  int width() const { return orientation_.lines_are_columns ? orientation_.line_count : orientation_.line_length; }
  int height() const { return orientation_.lines_are_columns ? orientation_.line_length : orientation_.line_count; }

  /// Columns need the whole picture before its first row.
  void prepare() {
    if (!orientation_.lines_are_columns) return;
    turned_.resize(static_cast<std::size_t>(width()) * static_cast<std::size_t>(height()));
    parallel_for(0, width(), [&](int x) {
      const auto column = static_cast<std::size_t>(orientation_.from_right ? width() - 1 - x : x);
      decode_line(bytes_, begins_[static_cast<std::size_t>(x)], height(), [&](std::size_t i, const Rgbe& texel) {
        turned_[i * static_cast<std::size_t>(width()) + column] = texel;
      });
    });
  }

  void read_row(int y, float* rgb) const {
    const auto line = static_cast<std::size_t>(orientation_.from_bottom ? height() - 1 - y : y);
    const auto count = static_cast<std::size_t>(width());
    if (orientation_.lines_are_columns) {
      for (std::size_t x = 0; x < count; ++x) to_float(turned_[line * count + x], rgb + 3 * x);
    } else {
      decode_line(bytes_, begins_[line], width(), [&](std::size_t i, const Rgbe& texel) {
        to_float(texel, rgb + 3 * (orientation_.from_right ? count - 1 - i : i));
      });
    }
  }

 private:
  RadianceBytes bytes_;
  Orientation orientation_;
  std::vector<std::size_t> begins_;
  std::vector<Rgbe> turned_;
};

}  // namespace

void stream_radiance(const std::string& path, const HdrBegin& begin, const HdrRows& rows) {
  const std::vector<std::byte> file = read_file(path, kMaxFileBytes);
  const RadianceBytes bytes(reinterpret_cast<const std::uint8_t*>(file.data()), file.size());
  std::size_t position = 0;
  const Header header = parse_header(path, bytes, position);
  const std::optional<glm::mat3> conversion = conversion_of(header);
  RowSource source(path, bytes, position, header.orientation);
  HdrInfo info{source.width(), source.height(), 3, false, header.warnings};
  info.converted = header.primaries && !is_rec709(*header.primaries);
  begin(info);
  source.prepare();
  const std::size_t row_floats = 3 * static_cast<std::size_t>(info.width);
  std::vector<float> strip(row_floats * static_cast<std::size_t>(std::min(kRadianceRows, info.height)));
  for (int first = 0; first < info.height; first += kRadianceRows) {
    const int count = std::min(kRadianceRows, info.height - first);
    parallel_for(0, count, [&](int r) {
      float* row = strip.data() + static_cast<std::size_t>(r) * row_floats;
      source.read_row(first + r, row);
      if (conversion) convert_colors(*conversion, static_cast<std::size_t>(info.width), 3, row);
    });
    rows(first, count, strip.data());
  }
}

}  // namespace maquette
