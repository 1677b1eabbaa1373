#include "scenes/image_io.h"

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfTiledOutputFile.h>
#include <gtest/gtest.h>
#include <stb/stb_image.h>
#include <stb/stb_image_write.h>

#include <cmath>
#include <limits>
#include <random>

#include "scenes/error.h"
#include "scenes/image_rows.h"
#include "tests/scenes/temporary_folder.h"

namespace maquette {
namespace {

using test::message_of;
using ImageIo = test::TemporaryFolder;

Image random_image(int width, int height, int channels) {
  Image image(width, height, channels);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> exponent(-8.0f, 8.0f);
  for (float& value : image.data) value = std::exp2(exponent(random));
  return image;
}

TEST_F(ImageIo, ExrKeepsEveryBit) {
  for (const int channels : {3, 4}) {
    Image image = random_image(37, 300, channels);
    image.at(3, 2, 1) = -1.5f;
    image.at(4, 2, 1) = std::numeric_limits<float>::infinity();
    save_exr(path("a.exr"), image, {{"maquette.mode", "uniform"}});
    const Image back = load_hdr_image(path("a.exr"));
    EXPECT_EQ(back.width, 37);
    EXPECT_EQ(back.height, 300);
    EXPECT_EQ(back.channels, channels);
    EXPECT_EQ(back.data, image.data);
    EXPECT_EQ(file_count(), 1u);
    Imf::InputFile file(path("a.exr").c_str());
    EXPECT_EQ(file.header().typedAttribute<Imf::StringAttribute>("maquette.mode").value(), "uniform");
  }
}

TEST_F(ImageIo, ExrCarriesLayers) {
  const Image image = random_image(19, 31, 4), variance = random_image(19, 31, 3);
  save_exr(path("a.exr"), image, {}, {{"variance", variance}});
  EXPECT_EQ(load_hdr_image(path("a.exr")).data, image.data) << "a reader of R, G, B, A sees the picture alone";
  Imf::InputFile file(path("a.exr").c_str());
  Image back(19, 31, 3);
  Imf::FrameBuffer buffer;
  const char* names[] = {"variance.R", "variance.G", "variance.B"};
  for (std::size_t c = 0; c < 3; ++c) {
    ASSERT_NE(file.header().channels().findChannel(names[c]), nullptr) << names[c];
    buffer.insert(names[c], Imf::Slice::Make(Imf::FLOAT, back.data.data() + c, {0, 0}, 19, 31, 3 * sizeof(float),
                                             3 * sizeof(float) * 19));
  }
  file.setFrameBuffer(buffer);
  file.readPixels(0, 30);
  EXPECT_EQ(back.data, variance.data);
}

TEST_F(ImageIo, ReadsTilesHalfUintAndAnOffsetWindow) {
  constexpr int kWidth = 100;
  constexpr int kHeight = 70;
  Imf::Header header(Imath::Box2i({0, 0}, {199, 199}), Imath::Box2i({-5, 7}, {-5 + kWidth - 1, 7 + kHeight - 1}));
  header.setTileDescription(Imf::TileDescription(32, 16));
  header.channels().insert("R", Imf::Channel(Imf::HALF));
  header.channels().insert("G", Imf::Channel(Imf::FLOAT));
  header.channels().insert("B", Imf::Channel(Imf::UINT));
  header.channels().insert("depth.Z", Imf::Channel(Imf::FLOAT));
  std::vector<half> red(kWidth * kHeight);
  std::vector<float> green(kWidth * kHeight);
  std::vector<unsigned> blue(kWidth * kHeight);
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const auto k = static_cast<std::size_t>(i);
    red[k] = half(static_cast<float>(i % 100) * 0.25f);
    green[k] = static_cast<float>(i) * 0.1f;
    blue[k] = static_cast<unsigned>(i);
  }
  {
    Imf::TiledOutputFile file(path("tiled.exr").c_str(), header);
    Imf::FrameBuffer buffer;
    buffer.insert("R", Imf::Slice::Make(Imf::HALF, red.data(), {-5, 7}, kWidth, kHeight));
    buffer.insert("G", Imf::Slice::Make(Imf::FLOAT, green.data(), {-5, 7}, kWidth, kHeight));
    buffer.insert("B", Imf::Slice::Make(Imf::UINT, blue.data(), {-5, 7}, kWidth, kHeight));
    buffer.insert("depth.Z", Imf::Slice::Make(Imf::FLOAT, green.data(), {-5, 7}, kWidth, kHeight));
    file.setFrameBuffer(buffer);
    file.writeTiles(0, file.numXTiles() - 1, 0, file.numYTiles() - 1);
  }
  const Image image = load_hdr_image(path("tiled.exr"));
  ASSERT_EQ(image.width, 200);
  ASSERT_EQ(image.height, 200);
  ASSERT_EQ(image.channels, 3);
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) {
      const bool stored = x < kWidth - 5 && y >= 7 && y < 7 + kHeight;
      const auto k = static_cast<std::size_t>((y - 7) * kWidth + x + 5);
      ASSERT_EQ(image.at(x, y, 0), stored ? static_cast<float>(red[k]) : 0.0f);
      ASSERT_EQ(image.at(x, y, 1), stored ? green[k] : 0.0f);
      ASSERT_EQ(image.at(x, y, 2), stored ? static_cast<float>(blue[k]) : 0.0f);
    }
  }
}

TEST_F(ImageIo, LuminanceAloneIsGrey) {
  Image grey(9, 300, 1);
  for (std::size_t i = 0; i < grey.data.size(); ++i) grey.data[i] = static_cast<float>(i);
  save_exr(path("y.exr"), grey);
  const Image image = load_hdr_image(path("y.exr"));
  ASSERT_EQ(image.channels, 3);
  for (std::size_t i = 0; i < grey.data.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) ASSERT_EQ(image.data[3 * i + c], grey.data[i]);
}

TEST_F(ImageIo, LuminanceWithChromaIsConverted) {
  constexpr int kSide = 32;
  std::vector<Imf::Rgba> texels(kSide * kSide, Imf::Rgba(0.5f, 2.0f, 4.0f));
  {
    Imf::RgbaOutputFile file(path("yc.exr").c_str(), kSide, kSide, Imf::WRITE_YC);
    file.setFrameBuffer(texels.data(), 1, kSide);
    file.writePixels(kSide);
  }
  const Image image = load_hdr_image(path("yc.exr"));
  EXPECT_NEAR(image.at(16, 16, 0), 0.5f, 0.02f);
  EXPECT_NEAR(image.at(16, 16, 1), 2.0f, 0.02f);
  EXPECT_NEAR(image.at(16, 16, 2), 4.0f, 0.04f);
}

TEST_F(ImageIo, RadianceAgreesWithStb) {
  // Width 5 has no run-length encoding, 40 has; stb_image is the independent reader.
  for (const int width : {5, 40, 300}) {
    Image image = random_image(width, 270, 3);
    for (int x = 0; x < width; ++x) image.at(x, 9, 0) = image.at(x, 9, 1) = image.at(x, 9, 2) = 0.25f;  // a run
    ASSERT_TRUE(stbi_write_hdr(path("a.hdr").c_str(), width, 270, 3, image.data.data()));
    const Image back = load_hdr_image(path("a.hdr"));
    int w = 0, h = 0, n = 0;
    float* expected = stbi_loadf(path("a.hdr").c_str(), &w, &h, &n, 3);
    ASSERT_NE(expected, nullptr);
    ASSERT_EQ(back.width, w);
    ASSERT_EQ(back.height, h);
    for (std::size_t i = 0; i < back.data.size(); ++i) ASSERT_EQ(back.data[i], expected[i]) << i;
    stbi_image_free(expected);
  }
}

TEST_F(ImageIo, RadianceOldRunsAreRead) {
  // One texel, then a run of 2 + 256 * 1 more (two run codes in a row).
  std::string bytes = "#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 259\n";
  bytes += std::string("\x40\x20\x10\x81", 4) + std::string("\1\1\1\2", 4) + std::string("\1\1\1\1", 4);
  const Image image = load_hdr_image(write("old.hdr", bytes));
  ASSERT_EQ(image.width, 259);
  EXPECT_FLOAT_EQ(image.at(258, 0, 0), 0.5f);
  EXPECT_FLOAT_EQ(image.at(258, 0, 2), 0.125f);
}

TEST_F(ImageIo, TruncatedFilesAreRefusedAtEveryLength) {
  const Image image = random_image(40, 33, 3);
  save_exr(path("a.exr"), image);
  ASSERT_TRUE(stbi_write_hdr(path("a.hdr").c_str(), 40, 33, 3, image.data.data()));
  for (const char* name : {"a.exr", "a.hdr"}) {
    const std::string whole = read(path(name));
    for (std::size_t length = 0; length + 1 < whole.size(); length += 1 + whole.size() / 97) {
      const std::string cut = write(std::string("cut-") + name, whole.substr(0, length));
      const std::string message = message_of<Error>([&] { load_hdr_image(cut); });
      EXPECT_NE(message.find("cut-"), std::string::npos);
      EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    }
  }
}

TEST_F(ImageIo, DamagedBytesNeverCrash) {
  const Image image = random_image(40, 33, 3);
  save_exr(path("a.exr"), image);
  ASSERT_TRUE(stbi_write_hdr(path("a.hdr").c_str(), 40, 33, 3, image.data.data()));
  std::mt19937 random(11);
  for (const char* name : {"a.exr", "a.hdr"}) {
    const std::string whole = read(path(name));
    for (int i = 0; i < 150; ++i) {
      std::string bytes = whole;
      for (int k = 0; k < 4; ++k) bytes[random() % bytes.size()] = static_cast<char>(random());
      try {
        const Image read_back = load_hdr_image(write(std::string("bad-") + name, bytes));
        EXPECT_EQ(read_back.data.size(), read_back.index(0, read_back.height));
      } catch (const Error&) {
        // an error is just as good
      }
    }
  }
}

TEST_F(ImageIo, AbsurdSizesAreRefusedBeforeMemoryIsTaken) {
  for (const char* size : {"-Y 1000000 +X 1000000", "-Y 65536 +X 65536", "-Y 0 +X 5", "-Y -3 +X 5",
                           "-Y 99999999999999999999 +X 5", "-Y 65000 +X 16000", "+X 5 -Y 5"}) {
    const std::string file = write("huge.hdr", std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n") + size + "\nabcd");
    EXPECT_THROW(load_hdr_image(file), Error) << size;
  }
  save_exr(path("a.exr"), Image(2, 2, 3));
  std::string bytes = read(path("a.exr"));
  const std::size_t window = bytes.find("dataWindow");
  ASSERT_NE(window, std::string::npos);
  const std::size_t max_x = window + std::string("dataWindow").size() + 1 + std::string("box2i").size() + 1 + 4 + 8;
  bytes.replace(max_x, 8, std::string("\xff\xff\xff\x3f\xff\xff\xff\x3f", 8));
  EXPECT_THROW(load_hdr_image(write("huge.exr", bytes)), Error);
}

TEST_F(ImageIo, SaysWhatIsWrongWithTheFile) {
  EXPECT_NE(message_of<Error>([&] { load_hdr_image(path("none.exr")); }).find("does not exist"), std::string::npos);
  EXPECT_NE(message_of<Error>([&] { load_hdr_image(path("")); }).find("folder"), std::string::npos);
  const std::string text = write("text.hdr", "hello, this is no image");
  EXPECT_NE(message_of<Error>([&] { load_hdr_image(text); }).find("neither"), std::string::npos);
  save_png(path("a.png"), Image(2, 2, 3));
  EXPECT_NE(message_of<Error>([&] { load_hdr_image(path("a.png")); }).find("neither"), std::string::npos);
  EXPECT_THROW(load_hdr_image(write("empty.exr", "")), Error);

  Imf::Header header(4, 4);
  header.channels().insert("Z", Imf::Channel(Imf::FLOAT));
  {
    Imf::OutputFile file(path("z.exr").c_str(), header);
    std::vector<float> depth(16);
    Imf::FrameBuffer buffer;
    buffer.insert("Z", Imf::Slice::Make(Imf::FLOAT, depth.data(), {0, 0}, 4, 4));
    file.setFrameBuffer(buffer);
    file.writePixels(4);
  }
  EXPECT_NE(message_of<Error>([&] { load_hdr_image(path("z.exr")); }).find("found: Z"), std::string::npos);
}

TEST_F(ImageIo, PngRoundsClampsAndShowsNanAsBlack) {
  Image image(3, 1, 3);
  image.at(0, 0, 0) = 0.5f;
  image.at(0, 0, 1) = 7.0f;
  image.at(0, 0, 2) = -1.0f;
  image.at(1, 0, 0) = std::numeric_limits<float>::quiet_NaN();
  image.at(1, 0, 1) = std::numeric_limits<float>::infinity();
  image.at(1, 0, 2) = 1.0f / 255.0f;
  save_png(path("a.png"), image);
  int w = 0, h = 0, n = 0;
  unsigned char* bytes = stbi_load(path("a.png").c_str(), &w, &h, &n, 0);
  ASSERT_NE(bytes, nullptr);
  EXPECT_EQ(w, 3);
  EXPECT_EQ(h, 1);
  EXPECT_EQ(n, 3);
  const std::vector<int> expected = {128, 255, 0, 0, 255, 1};
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(bytes[i], expected[i]) << i;
  stbi_image_free(bytes);
}

TEST_F(ImageIo, PngIsOpaque) {
  for (const int channels : {1, 2, 3, 4}) {
    Image image(2, 1, channels, 0.0f);
    for (int c = 0; c < channels; ++c) image.at(1, 0, c) = 0.2f * static_cast<float>(c + 1);
    save_png(path("a.png"), image);
    int w = 0, h = 0, n = 0;
    unsigned char* bytes = stbi_load(path("a.png").c_str(), &w, &h, &n, 0);
    ASSERT_NE(bytes, nullptr);
    ASSERT_EQ(n, channels < 3 ? 1 : 3);
    for (int c = 0; c < n; ++c) EXPECT_EQ(bytes[n + c], 51 * (c + 1)) << channels;
    stbi_image_free(bytes);
  }
}

TEST_F(ImageIo, UnwritablePathsLeaveNothing) {
  EXPECT_THROW(save_exr(path("no/such/folder/a.exr"), Image(2, 2, 3)), Error);
  EXPECT_THROW(save_png(path("no/such/folder/a.png"), Image(2, 2, 3)), Error);
  std::filesystem::create_directory(path("taken.exr"));
  EXPECT_THROW(save_exr(path("taken.exr"), Image(2, 2, 3)), Error);
  EXPECT_EQ(file_count(), 1u);
}

TEST_F(ImageIo, StripsArriveInOrderWithoutGaps) {
  const Image image = random_image(7, 1000, 3);
  save_exr(path("a.exr"), image);
  int next = 0;
  stream_hdr_image(
      path("a.exr"), HdrUse::picture, [&](const HdrInfo& info) { EXPECT_EQ(info.height, 1000); },
      [&](int first, int count, const float* values) {
        EXPECT_EQ(first, next);
        EXPECT_EQ(values[0], image.at(0, first, 0));
        next += count;
      });
  EXPECT_EQ(next, 1000);
}

}  // namespace
}  // namespace maquette
