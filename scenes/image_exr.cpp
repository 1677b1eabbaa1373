// The only file that includes OpenEXR.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfThreading.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/image_io.h"
#include "scenes/image_rows.h"

namespace maquette {
namespace {

constexpr int kStripRows = 256;  // the largest block of lines of any compression (DWAB)

enum class Layout { rgb, luminance, luminance_chroma };

void use_all_cores() {
  static std::once_flag once;
  std::call_once(once, [] { Imf::setGlobalThreadCount(static_cast<int>(std::thread::hardware_concurrency())); });
}

std::string join_channel_names(const Imf::ChannelList& channels) {
  std::string names;
  int count = 0;
  for (auto it = channels.begin(); it != channels.end(); ++it, ++count) {
    if (count == 12) return names + ", ...";
    names += (names.empty() ? "" : ", ") + std::string(it.name());
  }
  return names.empty() ? "none" : names;
}

std::optional<Layout> find_layout(const Imf::ChannelList& channels) {
  const auto has = [&](const char* name) { return channels.findChannel(name) != nullptr; };
  if (has("R") && has("G") && has("B")) return Layout::rgb;
  if (has("Y") && has("RY") && has("BY")) return Layout::luminance_chroma;
  if (has("Y")) return Layout::luminance;
  return std::nullopt;
}

bool is_flat(const Imf::Header& header) {
  return !header.hasType() || header.type() == Imf::SCANLINEIMAGE || header.type() == Imf::TILEDIMAGE;
}

HdrInfo read_info(const std::string& path, const Imf::Header& header) {
  const Imath::Box2i window = header.dataWindow();
  const long long width = static_cast<long long>(window.max.x) - window.min.x + 1;
  const long long height = static_cast<long long>(window.max.y) - window.min.y + 1;
  check_image_size(path, width, height);
  return {static_cast<int>(width), static_cast<int>(height), header.channels().findChannel("A") ? 4 : 3};
}

/// R, G, B (A) or Y as floats; Y is copied to all three channels.
void stream_plain(const std::string& path, Imf::InputPart& part, Layout layout, const HdrInfo& info,
                  const HdrRows& rows) {
  const Imath::V2i origin = part.header().dataWindow().min;
  const auto channel_count = static_cast<std::size_t>(info.channels);
  const auto width = static_cast<std::size_t>(info.width);
  std::vector<float> strip(width * static_cast<std::size_t>(std::min(kStripRows, info.height)) * channel_count);
  const std::array<const char*, 4> names = layout == Layout::rgb ? std::array<const char*, 4>{"R", "G", "B", "A"}
                                                                 : std::array<const char*, 4>{"Y", "", "", "A"};
  for (const char* name : names) {
    const Imf::Channel* channel = *name ? part.header().channels().findChannel(name) : nullptr;
    if (channel && (channel->xSampling != 1 || channel->ySampling != 1))
      throw Error(path, std::string("the EXR channel ") + name + " is subsampled", "store it at full resolution");
  }
  for (int first = 0; first < info.height; first += kStripRows) {
    const int count = std::min(kStripRows, info.height - first);
    Imf::FrameBuffer buffer;
    for (std::size_t c = 0; c < channel_count; ++c) {
      if (!*names[c]) continue;
      buffer.insert(names[c],
                    Imf::Slice::Make(Imf::FLOAT, strip.data() + c, {origin.x, origin.y + first}, info.width, count,
                                     channel_count * sizeof(float), width * channel_count * sizeof(float)));
    }
    part.setFrameBuffer(buffer);
    part.readPixels(origin.y + first, origin.y + first + count - 1);
    if (layout == Layout::luminance) {
      for (std::size_t i = 0; i < width * static_cast<std::size_t>(count); ++i)
        strip[i * channel_count + 1] = strip[i * channel_count + 2] = strip[i * channel_count];
    }
    rows(first, count, strip.data());
  }
}

/// Luminance and subsampled chroma, converted by OpenEXR, in half precision as they are stored.
void stream_chroma(const std::string& path, const HdrInfo& info, const HdrRows& rows) {
  Imf::RgbaInputFile file(path.c_str());
  const Imath::V2i origin = file.dataWindow().min;
  const auto channel_count = static_cast<std::size_t>(info.channels);
  const auto width = static_cast<std::size_t>(info.width);
  std::vector<Imf::Rgba> row(width);
  std::vector<float> values(width * channel_count);
  for (int y = 0; y < info.height; ++y) {
    file.setFrameBuffer(row.data() - origin.x, 1, 0);
    file.readPixels(origin.y + y);
    for (std::size_t x = 0; x < width; ++x) {
      const std::array<float, 4> rgba = {row[x].r, row[x].g, row[x].b, row[x].a};
      std::copy_n(rgba.begin(), channel_count, values.begin() + static_cast<std::ptrdiff_t>(x * channel_count));
    }
    rows(y, 1, values.data());
  }
}

}  // namespace

void stream_exr(const std::string& path, const HdrBegin& begin, const HdrRows& rows) {
  use_all_cores();
  try {
    Imf::MultiPartInputFile file(path.c_str());
    std::string found;
    for (int p = 0; p < file.parts(); ++p) {
      const Imf::Header& header = file.header(p);
      const std::optional<Layout> layout = find_layout(header.channels());
      if (!layout || !is_flat(header)) {
        found +=
            (found.empty() ? "" : "; ") + (is_flat(header) ? join_channel_names(header.channels()) : "a deep image");
        continue;
      }
      const HdrInfo info = read_info(path, header);
      if (!file.partComplete(p)) throw Error(path, "the EXR file is truncated", "copy it again");
      begin(info);
      Imf::InputPart part(file, p);
      return *layout == Layout::luminance_chroma && file.parts() == 1 ? stream_chroma(path, info, rows)
                                                                      : stream_plain(path, part, *layout, info, rows);
    }
    throw Error(path, "the EXR file has no R, G, B or Y channels (found: " + found + ")", "store it as RGB");
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

namespace {

/// Declares the image's channels, each with `prefix`, in header and frame buffer.
void add_channels(const std::string& prefix, const Image& image, Imf::Header* header, Imf::FrameBuffer* buffer) {
  assert(image.width > 0 && image.height > 0 && (image.channels == 1 || image.channels == 3 || image.channels == 4));
  assert(image.data.size() == image.index(0, image.height));
  static constexpr std::array<const char*, 4> kColour = {"R", "G", "B", "A"};
  const auto count = static_cast<std::size_t>(image.channels);
  for (std::size_t c = 0; c < count; ++c) {
    const std::string name = prefix + (count == 1 ? "Y" : kColour[c]);
    header->channels().insert(name.c_str(), Imf::Channel(Imf::FLOAT));
    buffer->insert(name.c_str(), Imf::Slice::Make(Imf::FLOAT, image.data.data() + c, {0, 0}, image.width, image.height,
                                                  count * sizeof(float),
                                                  count * sizeof(float) * static_cast<std::size_t>(image.width)));
  }
}

}  // namespace

void save_exr(const std::string& path, const Image& image, const std::map<std::string, std::string>& attributes,
              const ImageLayers& layers) {
  use_all_cores();
  try {
    write_atomically(path, [&](const std::string& temporary) {
      Imf::Header header(image.width, image.height);
      header.compression() = Imf::ZIP_COMPRESSION;
      for (const auto& [name, value] : attributes) header.insert(name.c_str(), Imf::StringAttribute(value));
      Imf::FrameBuffer buffer;
      add_channels("", image, &header, &buffer);
      for (const auto& [name, layer] : layers) {
        assert(layer.width == image.width && layer.height == image.height);
        add_channels(name + ".", layer, &header, &buffer);
      }
      Imf::OutputFile file(temporary.c_str(), header);
      file.setFrameBuffer(buffer);
      file.writePixels(image.height);
    });
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    std::string what = error.what();
    std::replace(what.begin(), what.end(), '\n', ' ');
    throw Error(path, "cannot write the EXR file (" + what + ")", "check the folder and the free space");
  }
}

}  // namespace maquette
