#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfEnvmapAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <vector>

#include "scenes/error.h"
#include "scenes/exr_stream.h"
#include "scenes/image_color.h"
#include "scenes/image_exr_channels.h"
#include "scenes/image_exr_threads.h"
#include "scenes/image_rows.h"

namespace maquette {
namespace {

using Layout = ExrPicture::Layout;
constexpr int kStripRows = 256;  // the largest block of lines of any compression (DWAB)

/// Weights of the stored chroma samples at the distances 1, 3, ... 13 from a pixel without one.
/// Source: OpenEXR, ImfRgbaYca.cpp, reconstructChromaHoriz.
constexpr std::array<float, 7> kChromaFilter = {0.627123f, -0.186077f, 0.087929f, -0.043159f,
                                                0.019597f, -0.007540f, 0.002128f};
constexpr int kChromaReach = 2 * static_cast<int>(kChromaFilter.size()) - 1;

/// How the stored values become Rec.709.
struct ColorSpace {
  std::optional<glm::mat3> rec709_from_file;  ///< nothing when they are Rec.709
  glm::vec3 luminance_weights{0.0f};
};

ColorSpace read_color_space(const Imf::Header& header, std::vector<std::string>* warnings) {
  ColorSpace space;
  Primaries primaries;
  if (Imf::hasChromaticities(header)) {
    const Imf::Chromaticities& c = Imf::chromaticities(header);
    const auto vector = [](const Imath::V2f& v) { return glm::dvec2(v.x, v.y); };
    const Primaries stored{vector(c.red), vector(c.green), vector(c.blue), vector(c.white)};
    if (xyz_from_rgb(stored))
      primaries = stored;
    else
      warnings->push_back("its chromaticities describe no colour space; its colours are taken as Rec.709");
  }
  if (!is_rec709(primaries)) space.rec709_from_file = glm::mat3(rec709_from_rgb(primaries));
  const glm::dmat3 xyz = *xyz_from_rgb(primaries);
  space.luminance_weights = glm::vec3(xyz[0].y, xyz[1].y, xyz[2].y);
  return space;
}

struct Window {
  int x = 0, y = 0, width = 0, height = 0;
  bool operator==(const Window&) const = default;
};

Window checked_window(const std::string& path, const Imath::Box2i& box) {
  const long long width = static_cast<long long>(box.max.x) - box.min.x + 1;
  const long long height = static_cast<long long>(box.max.y) - box.min.y + 1;
  check_image_size(path, width, height);
  return {box.min.x, box.min.y, static_cast<int>(width), static_cast<int>(height)};
}

/// Reads rows of the data window as R G B (A) in the colour space of the file.
class RowReader {
 public:
  RowReader(const std::string& path, Imf::MultiPartInputFile* file, const ExrPicture& picture, const Window& window,
            const glm::vec3& luminance_weights)
      : picture_(picture),
        window_(window),
        weights_(luminance_weights),
        channel_count_(picture.has_alpha ? 4 : 3),
        row_floats_(static_cast<std::size_t>(window.width) * channel_count_) {
    for (const ExrChannel& channel : picture.channels) {
      if (!file->partComplete(channel.part)) throw Error(path, "the EXR file is truncated", "copy it again");
      parts_.try_emplace(channel.part, *file, channel.part);
      check_sampling(path, channel);
    }
    if (picture.layout == Layout::luminance_chroma && !(weights_.y > 1e-3f))
      throw Error(path, "its chromaticities leave green without luminance, so chroma cannot be converted",
                  "store it as RGB");
  }

  /// `y` is counted from the first row of the data window.
  void read(int y, int count, float* values) {
    if (picture_.layout == Layout::rgb) {
      read_channels({0, 1, 2}, y, count, values);
    } else {
      read_channels({0}, y, count, values);
    }
    const std::size_t texel_count = static_cast<std::size_t>(window_.width) * static_cast<std::size_t>(count);
    if (picture_.layout == Layout::luminance) {
      for (std::size_t i = 0; i < texel_count; ++i)
        values[i * channel_count_ + 1] = values[i * channel_count_ + 2] = values[i * channel_count_];
    } else if (picture_.layout == Layout::luminance_chroma) {
      const std::vector<float> ry = read_chroma(picture_.channels[1], y, count);
      const std::vector<float> by = read_chroma(picture_.channels[2], y, count);
      for (std::size_t i = 0; i < texel_count; ++i) convert_chroma(ry[i], by[i], values + i * channel_count_);
    }
  }

 private:
  void check_sampling(const std::string& path, const ExrChannel& channel) const {
    const bool chroma = channel.name.ends_with("RY") || channel.name.ends_with("BY");
    const int most = chroma ? 2 : 1;
    if (channel.x_sampling > most || channel.y_sampling > most)
      throw Error(path,
                  "the EXR channel " + channel.name + " is subsampled by " + std::to_string(channel.x_sampling) +
                      " x " + std::to_string(channel.y_sampling) + ", at most " + std::to_string(most) + " x " +
                      std::to_string(most) + " is read",
                  "store it at full resolution");
  }

  /// Channels of the picture to their places in the interleaved rows, alpha too.
  void read_channels(std::vector<std::size_t> channels, int y, int count, float* values) {
    const std::size_t colors = channels.size();
    if (picture_.has_alpha) channels.push_back(picture_.channels.size() - 1);
    std::map<int, Imf::FrameBuffer> buffers;
    for (std::size_t i = 0; i < channels.size(); ++i) {
      const ExrChannel& channel = picture_.channels[channels[i]];
      buffers[channel.part].insert(
          channel.name,
          Imf::Slice::Make(Imf::FLOAT, values + (i < colors ? i : 3), {window_.x, window_.y + y}, window_.width, count,
                           channel_count_ * sizeof(float), row_floats_ * sizeof(float)));
    }
    for (const auto& [p, buffer] : buffers) {
      Imf::InputPart& part = parts_.at(p);
      part.setFrameBuffer(buffer);
      part.readPixels(window_.y + y, window_.y + y + count - 1);
    }
  }

  /// A chroma channel at full resolution.
  std::vector<float> read_chroma(const ExrChannel& channel, int y, int count) {
    const int sx = channel.x_sampling, sy = channel.y_sampling;
    const int reach = sy == 2 ? kChromaReach : 0;
    // The data window begins at a sample: OpenEXR refuses other files.
    const int first = std::max(0, y - reach) / sy * sy;
    const int last = std::min(window_.height - 1, y + count - 1 + reach);
    const int columns = (window_.width + sx - 1) / sx, rows = (last - first) / sy + 1;
    std::vector<float> stored(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    Imf::FrameBuffer buffer;
    buffer.insert(channel.name, Imf::Slice::Make(Imf::FLOAT, stored.data(), {window_.x, window_.y + first},
                                                 window_.width, last - first + 1, sizeof(float),
                                                 static_cast<std::size_t>(columns) * sizeof(float), sx, sy));
    Imf::InputPart& part = parts_.at(channel.part);
    part.setFrameBuffer(buffer);
    part.readPixels(window_.y + first, window_.y + last);

    // First the missing rows, then the missing columns.
    std::vector<float> full(static_cast<std::size_t>(window_.width) * static_cast<std::size_t>(count));
    std::vector<float> row(static_cast<std::size_t>(columns));
    for (int r = 0; r < count; ++r) {
      const int at = y + r - first;
      for (int c = 0; c < columns; ++c)
        row[static_cast<std::size_t>(c)] = interpolate(at, sy, rows - 1, [&](int i) {
          return stored[static_cast<std::size_t>(i) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(c)];
        });
      float* target = &full[static_cast<std::size_t>(r) * static_cast<std::size_t>(window_.width)];
      for (int x = 0; x < window_.width; ++x)
        target[x] = interpolate(x, sx, columns - 1, [&](int i) { return row[static_cast<std::size_t>(i)]; });
    }
    return full;
  }

  /// Value at pixel `at` of samples at every `sampling`-th pixel; the last ones continue beyond the edges.
  template <class Sample>
  static float interpolate(int at, int sampling, int last_sample, const Sample& sample) {
    if (at % sampling == 0) return sample(at / sampling);
    float sum = 0.0f;
    for (int i = 0; i < static_cast<int>(kChromaFilter.size()); ++i) {
      const int left = std::max(0, at / 2 - i), right = std::min(last_sample, at / 2 + 1 + i);
      sum += kChromaFilter[static_cast<std::size_t>(i)] * (sample(left) + sample(right));
    }
    return sum;
  }

  /// Source: OpenEXR, ImfRgbaYca.cpp, YCAtoRGBA. Differs: ringing of the chroma filter is only desaturated where it
  /// makes a component negative.
  void convert_chroma(float ry, float by, float* values) const {
    const float y = values[0];
    glm::vec3 rgb(y);
    if (ry != 0.0f || by != 0.0f) {
      rgb.x = (ry + 1.0f) * y;
      rgb.z = (by + 1.0f) * y;
      rgb.y = (y - rgb.x * weights_.x - rgb.z * weights_.z) / weights_.y;
      if (picture_.channels[1].x_sampling > 1 || picture_.channels[1].y_sampling > 1)
        rgb = desaturate_into_gamut(rgb, weights_);
    }
    std::copy_n(&rgb[0], 3, values);
  }

  const ExrPicture& picture_;
  const Window window_;
  const glm::vec3 weights_{};
  const std::size_t channel_count_, row_floats_;
  std::map<int, Imf::InputPart> parts_;
};

/// Streams `canvas` of a picture that is stored in `data`: 0 outside it.
void stream_canvas(RowReader* reader, const Window& data, const Window& canvas, const ColorSpace& space, int channels,
                   const HdrRows& rows) {
  const auto channel_count = static_cast<std::size_t>(channels);
  const std::size_t row_floats = static_cast<std::size_t>(canvas.width) * channel_count;
  const std::size_t data_floats = static_cast<std::size_t>(data.width) * channel_count;
  std::vector<float> strip(row_floats * static_cast<std::size_t>(std::min(kStripRows, canvas.height)));
  std::vector<float> stored;
  // 64 bits: windows may begin anywhere.
  const long long left = std::max<long long>(canvas.x, data.x);
  const long long right =
      std::min<long long>(static_cast<long long>(canvas.x) + canvas.width, static_cast<long long>(data.x) + data.width);
  for (int first = 0; first < canvas.height; first += kStripRows) {
    const int count = std::min(kStripRows, canvas.height - first);
    const long long shift = static_cast<long long>(canvas.y) - data.y;
    const long long begin = std::max<long long>(0, first + shift);
    const long long end = std::min<long long>(data.height, first + shift + count);
    if (data == canvas) {
      reader->read(first, count, strip.data());
    } else {
      std::fill(strip.begin(), strip.end(), 0.0f);
      if (begin < end && left < right) {
        stored.resize(data_floats * static_cast<std::size_t>(end - begin));
        reader->read(static_cast<int>(begin), static_cast<int>(end - begin), stored.data());
      }
      for (long long y = begin; y < end && left < right; ++y)
        std::copy_n(&stored[static_cast<std::size_t>(y - begin) * data_floats +
                            static_cast<std::size_t>(left - data.x) * channel_count],
                    static_cast<std::size_t>(right - left) * channel_count,
                    &strip[static_cast<std::size_t>(y - shift - first) * row_floats +
                           static_cast<std::size_t>(left - canvas.x) * channel_count]);
    }
    if (space.rec709_from_file)
      convert_colors(*space.rec709_from_file, static_cast<std::size_t>(canvas.width) * static_cast<std::size_t>(count),
                     channels, strip.data());
    rows(first, count, strip.data());
  }
}

void stream_picture(const std::string& path, HdrUse use, const HdrBegin& begin, const HdrRows& rows) {
  Imf::MultiPartInputFile file(checked_exr(path));
  HdrInfo info;
  const ExrPicture picture = choose_exr_picture(path, file, &info.warnings);
  const Imf::Header& header = file.header(picture.channels[0].part);
  if (use == HdrUse::environment && Imf::hasEnvmap(header) && Imf::envmap(header) == Imf::ENVMAP_CUBE)
    throw Error(path, "is a cube map (attribute envmap), expected latitude and longitude", "convert it");
  const ColorSpace space = read_color_space(header, &info.warnings);
  const Window data = checked_window(path, header.dataWindow());
  const Window canvas = use == HdrUse::picture ? checked_window(path, header.displayWindow()) : data;
  info.width = canvas.width;
  info.height = canvas.height;
  info.channels = picture.has_alpha ? 4 : 3;
  info.converted = space.rec709_from_file.has_value();
  RowReader reader(path, &file, picture, data, space.luminance_weights);
  begin(info);
  stream_canvas(&reader, data, canvas, space, info.channels, rows);
}

}  // namespace

void stream_exr(const std::string& path, HdrUse use, const HdrBegin& begin, const HdrRows& rows) {
  use_all_cores_for_exr();
  try {
    stream_picture(path, use, begin, rows);
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw Error(path, "not enough memory for this EXR file", "make it smaller");
  } catch (const std::exception& error) {
    // OpenEXR repeats the path and may use several lines.
    std::string what = error.what();
    std::replace(what.begin(), what.end(), '\n', ' ');
    throw Error(path, "damaged EXR file (" + what + ")", "copy or export it again");
  }
}

}  // namespace maquette
