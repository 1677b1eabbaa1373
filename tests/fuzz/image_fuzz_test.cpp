// Damaged images must load or say why. MAQUETTE_TEST_SEED=N damages them elsewhere.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <gtest/gtest.h>
#include <webp/encode.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "scenes/environment.h"
#include "scenes/error.h"
#include "scenes/image_io.h"
#include "scenes/texture_formats.h"
#include "tests/scenes/temporary_folder.h"
#include "tests/scenes/texture_bytes.h"
#include "tests/support/chi_square.h"

namespace maquette {
namespace {

constexpr int kRounds = 120;  // of each sample
constexpr int kWidth = 36, kHeight = 20;

/// A few bytes replaced, half of them in the first 400, where the headers are; sometimes cut.
std::string damaged(std::string bytes, std::mt19937* random) {
  std::mt19937& next = *random;
  const int count = 1 + static_cast<int>(next() % 4);
  for (int k = 0; k < count; ++k) {
    const std::size_t range = next() % 2 ? bytes.size() : std::min<std::size_t>(bytes.size(), 400);
    char& byte = bytes[next() % range];
    // Single bits and extreme values pass more checks than noise.
    const unsigned kind = next() % 4;
    byte = kind == 0   ? static_cast<char>(next())
           : kind == 1 ? static_cast<char>(byte ^ (1 << next() % 8))
                       : static_cast<char>(kind == 2 ? 0 : 255);
  }
  if (next() % 8 == 0) bytes.resize(next() % bytes.size());
  return bytes;
}

class ImageFuzz : public test::TemporaryFolder {
 protected:
  ImageFuzz() : random_(test::test_seed(17)) {}

  /// Both uses of each damaged copy give a sound image or one line.
  void expect_sound(const std::string& original, const std::string& name) {
    ASSERT_NO_THROW(load_hdr_image(write(name, original)));
    for (int round = 0; round < kRounds; ++round) {
      const std::string file = write(name, damaged(original, &random_));
      attempt([&] {
        const Image image = load_hdr_image(file);
        EXPECT_EQ(image.data.size(), image.index(0, image.height));
      });
      attempt([&] {
        for (const glm::vec3& rgb : load_environment(file).rgb)
          for (int c = 0; c < 3; ++c) ASSERT_TRUE(std::isfinite(rgb[c]) && rgb[c] >= 0.0f);
      });
    }
  }

  template <class Call>
  static void attempt(const Call& call) {
    try {
      call();
    } catch (const Error& e) {
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
      EXPECT_LT(std::string(e.what()).size(), 1000u);
    }
  }

  Imf::Header header(Imf::Compression compression) const {
    Imf::Header result(Imath::Box2i({0, 0}, {kWidth + 3, kHeight - 3}),
                       Imath::Box2i({2, 0}, {kWidth + 1, kHeight - 1}));
    result.compression() = compression;
    Imf::addChromaticities(result, Imf::Chromaticities({0.7f, 0.3f}, {0.2f, 0.7f}, {0.1f, 0.1f}, {0.3f, 0.3f}));
    return result;
  }

  /// Wavy channels; chroma at every second pixel.
  static void add_channels(std::initializer_list<const char*> names, std::vector<std::vector<float>>* planes,
                           Imf::Header* header, Imf::FrameBuffer* buffer) {
    for (const std::string name : names) {
      const int sampling = name == "RY" || name == "BY" ? 2 : 1;
      std::vector<float>& plane = planes->emplace_back();
      for (int i = 0; i < kWidth * kHeight / sampling / sampling; ++i)
        plane.push_back(1.0f + 0.5f * std::sin(static_cast<float>(i)));
      header->channels().insert(name, Imf::Channel(Imf::FLOAT, sampling, sampling));
      buffer->insert(
          name, Imf::Slice::Make(Imf::FLOAT, plane.data(), header->dataWindow().min, kWidth, kHeight, sizeof(float),
                                 static_cast<std::size_t>(kWidth / sampling) * sizeof(float), sampling, sampling));
    }
  }

  std::mt19937 random_;
};

TEST_F(ImageFuzz, ExrOfEveryCompression) {
  for (int compression = 0; compression < Imf::NUM_COMPRESSION_METHODS; ++compression) {
    for (const bool chroma : {false, true}) {
      {
        std::vector<std::vector<float>> planes;
        Imf::Header h = header(static_cast<Imf::Compression>(compression));
        Imf::FrameBuffer buffer;
        if (chroma)
          add_channels({"Y", "RY", "BY"}, &planes, &h, &buffer);
        else
          add_channels({"R", "G", "B", "A", "layer.R", "Z"}, &planes, &h, &buffer);
        Imf::OutputFile file(path("whole.exr").c_str(), h);
        file.setFrameBuffer(buffer);
        file.writePixels(kHeight);
      }
      expect_sound(read(path("whole.exr")), "a.exr");
    }
  }
}

TEST_F(ImageFuzz, ExrOfTiles) {
  for (const Imf::LevelMode mode : {Imf::ONE_LEVEL, Imf::MIPMAP_LEVELS, Imf::RIPMAP_LEVELS}) {
    {
      std::vector<std::vector<float>> planes;
      Imf::Header h = header(Imf::ZIP_COMPRESSION);
      h.setTileDescription(Imf::TileDescription(16, 8, mode));
      Imf::FrameBuffer buffer;
      add_channels({"R", "G", "B"}, &planes, &h, &buffer);
      Imf::TiledOutputFile file(path("whole.exr").c_str(), h);
      file.setFrameBuffer(buffer);
      for (int y = 0; y < file.numYLevels(); ++y)
        for (int x = 0; x < file.numXLevels(); ++x)
          if (file.isValidLevel(x, y)) file.writeTiles(0, file.numXTiles(x) - 1, 0, file.numYTiles(y) - 1, x, y);
    }
    expect_sound(read(path("whole.exr")), "a.exr");
  }
}

TEST_F(ImageFuzz, ExrOfSeveralParts) {
  {
    std::vector<std::vector<float>> planes;
    std::vector<Imf::Header> headers(4, header(Imf::PIZ_COMPRESSION));
    std::vector<Imf::FrameBuffer> buffers(4);
    const std::initializer_list<const char*> names[] = {{"Z"}, {"R", "A"}, {"G"}, {"B", "other.R"}};
    for (std::size_t p = 0; p < 4; ++p) {
      headers[p].setName("part" + std::to_string(p));
      headers[p].setType(Imf::SCANLINEIMAGE);
      add_channels(names[p], &planes, &headers[p], &buffers[p]);
    }
    Imf::MultiPartOutputFile file(path("whole.exr").c_str(), headers.data(), 4);
    for (int p = 0; p < 4; ++p) {
      Imf::OutputPart part(file, p);
      part.setFrameBuffer(buffers[static_cast<std::size_t>(p)]);
      part.writePixels(kHeight);
    }
  }
  expect_sound(read(path("whole.exr")), "a.exr");
}

TEST_F(ImageFuzz, Radiance) {
  for (const char* size : {"-Y 20 +X 36", "+X 20 -Y 36", "-X 120 +Y 6"}) {
    const int length = size[0] == '-' && size[1] == 'X' ? 6 : 36;
    std::string bytes = "#?RADIANCE\nEXPOSURE=2\nCOLORCORR=1 2 1\nPRIMARIES=0.7 0.3 0.2 0.7 0.1 0.1 0.3 0.3\n\n";
    bytes += std::string(size) + "\n";
    for (int line = 0; line < 720 / length; ++line) {
      std::string texels;
      for (int i = 0; i < 4 * length; ++i) texels.push_back(static_cast<char>(100 + (i * line) % 50));
      if (length < 8)
        bytes += texels;
      else
        bytes += std::string("\2\2\0\x24", 4) + std::string("\xa4\x60\xa4\x70\x24", 5) + texels.substr(0, 36) +
                 std::string("\xa4\x80", 2);
    }
    expect_sound(bytes, "a.hdr");
  }
}

TEST_F(ImageFuzz, Textures) {
  std::string rows, palette;
  for (int y = 0; y < kHeight; ++y) {
    rows.push_back('\0');
    for (int x = 0; x < 8 * kWidth; ++x) rows.push_back(static_cast<char>(x * y));
  }
  for (int i = 0; i < 768; ++i) palette.push_back(static_cast<char>(i));
  std::vector<std::vector<int>> blocks;
  for (int i = 0; i < 20; ++i) blocks.push_back({i * 11, 255 - i * 10, i * 7 % 256});
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < 4 * kWidth * kHeight; ++i) rgba.push_back(static_cast<std::uint8_t>(i * i / 7));
  std::vector<std::string> samples = {
      test::png_bytes(kWidth, kHeight, 16, 6, rows),
      test::png_bytes(8 * kWidth, kHeight, 8, 3, rows,
                      test::png_chunk("PLTE", palette) + test::png_chunk("tRNS", std::string(256, '\x80'))),
      test::jpeg_bytes(blocks), test::jpeg_bytes(blocks, true), test::jpeg_bytes({{1, 2, 3, 4}}, false, 2)};
  for (const bool lossless : {false, true}) {
    std::uint8_t* data = nullptr;
    const std::size_t size = lossless ? WebPEncodeLosslessRGBA(rgba.data(), kWidth, kHeight, 4 * kWidth, &data)
                                      : WebPEncodeRGBA(rgba.data(), kWidth, kHeight, 4 * kWidth, 50.0f, &data);
    samples.emplace_back(reinterpret_cast<const char*>(data), size);
    WebPFree(data);
  }
  const auto decode = [](const std::string& bytes) {
    TextureImage image;
    std::vector<std::string> notes;
    decode_texture(std::as_bytes(std::span(bytes)), &image, &notes);
    EXPECT_EQ(image.rgba.size(), 4 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  };
  for (const std::string& whole : samples) {
    ASSERT_NO_THROW(decode(whole));
    for (int round = 0; round < 4 * kRounds; ++round) {
      std::string bytes = damaged(whole, &random_);
      // The checksums of the chunks are mended half of the time: what they protect must be safe too.
      if (bytes.size() > 57 && round % 2) {
        for (std::size_t i = 8; i + 12 <= bytes.size();) {
          std::size_t length = 0;
          for (std::size_t k = 0; k < 4; ++k) length = length << 8 | static_cast<std::uint8_t>(bytes[i + k]);
          if (length > bytes.size() - i - 12) break;
          std::string sum;
          test::put_big_endian(test::png_checksum(bytes.substr(i + 4, length + 4)), &sum);
          if (texture_format(std::as_bytes(std::span(bytes))) == TextureFormat::png)
            bytes.replace(i + 8 + length, 4, sum);
          i += 12 + length;
        }
      }
      attempt([&] { decode(bytes); });
    }
  }
}

}  // namespace
}  // namespace maquette
