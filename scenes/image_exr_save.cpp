#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>

#include <algorithm>
#include <array>
#include <cassert>

#include "scenes/error.h"
#include "scenes/exr_stream.h"
#include "scenes/files.h"
#include "scenes/image_exr_threads.h"
#include "scenes/image_io.h"

namespace maquette {
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
  use_all_cores_for_exr();
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
      ExrStream stream(temporary);
      {
        Imf::OutputFile file(stream, header);
        file.setFrameBuffer(buffer);
        file.writePixels(image.height);
      }
      stream.close();
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
