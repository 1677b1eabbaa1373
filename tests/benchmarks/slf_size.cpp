#include "tests/benchmarks/slf_size.h"

#include <Imath/half.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>

#include <array>
#include <filesystem>
#include <vector>

#include "render/slf/buffers.h"

namespace maquette::bench {

namespace {

constexpr int kAtlasWidth = 1024;

/// [pixel] R, G, B.
std::size_t bytes_of_zip(const std::vector<std::array<half, 3>>& pixels, const std::string& path) {
  const int height = static_cast<int>(pixels.size()) / kAtlasWidth;
  Imf::Header header(kAtlasWidth, height);
  header.compression() = Imf::ZIP_COMPRESSION;
  Imf::FrameBuffer buffer;
  const char* const names[] = {"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) {
    header.channels().insert(names[c], Imf::Channel(Imf::HALF));
    // The library reads through a pointer to char.
    auto* first = reinterpret_cast<char*>(const_cast<half*>(&pixels[0][c]));
    buffer.insert(names[c], Imf::Slice(Imf::HALF, first, sizeof pixels[0], kAtlasWidth * sizeof pixels[0]));
  }
  {
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(height);
  }
  const std::size_t bytes = std::filesystem::file_size(path);
  std::filesystem::remove(path);
  return bytes;
}

}  // namespace

std::size_t bytes_of_slices(const OutgoingField& field, const std::string& scratch) {
  const auto texels = static_cast<std::size_t>(field.radiance.cols());
  std::vector<std::array<half, 3>> pixels((texels + kAtlasWidth - 1) / kAtlasWidth * kAtlasWidth);
  std::filesystem::create_directories(scratch);
  std::size_t bytes = 0;
  for (Eigen::Index bin = 0; bin < field.radiance.rows() / 3; ++bin) {
    for (std::size_t t = 0; t < texels; ++t)
      for (Eigen::Index c = 0; c < 3; ++c)
        pixels[t][static_cast<std::size_t>(c)] = field.radiance(3 * bin + c, static_cast<Eigen::Index>(t));
    bytes += bytes_of_zip(pixels, (std::filesystem::path(scratch) / "slice.exr").string());
  }
  return bytes;
}

std::size_t bytes_resident(const LightField& field, std::size_t texels, std::size_t bins) {
  const auto components = static_cast<std::size_t>(field.fit.weights.rows());
  const std::size_t layers = (components + 3) / 4, clusters = static_cast<std::size_t>(field.fit.pca.cluster_count());
  const double finer = static_cast<double>(lumisphere_table_side(field.side)) / field.side;
  const auto read = static_cast<std::size_t>(finer * finer * static_cast<double>(bins));
  return texels * (4 + 8 * layers) + clusters * (components + 1) * read * 8;
}

}  // namespace maquette::bench
