#include "scenes/texture_formats.h"

#include <gtest/gtest.h>
#include <webp/encode.h>

#include <cstdlib>

#include "scenes/error.h"
#include "tests/scenes/temporary_folder.h"
#include "tests/scenes/texture_bytes.h"

namespace maquette {
namespace {

using test::jpeg_bytes;
using test::message_of;
using test::Pixels;
using test::png_bytes;
using test::png_chunk;

std::span<const std::byte> as_bytes(const std::string& text) { return std::as_bytes(std::span(text)); }

struct Decoded {
  TextureImage image;
  std::vector<std::string> notes;
};

Decoded decode(const std::string& bytes) {
  Decoded out;
  decode_texture(as_bytes(bytes), &out.image, &out.notes);
  return out;
}

void expect_texels(const std::string& bytes, int width, const Pixels& expected) {
  const Decoded out = decode(bytes);
  EXPECT_EQ(out.image.width, width);
  EXPECT_EQ(out.image.height * width * 4, static_cast<int>(expected.size()));
  EXPECT_EQ(out.image.rgba, expected);
  EXPECT_TRUE(out.notes.empty());
}

std::string webp_bytes(const Pixels& rgba, int width, int height) {
  std::uint8_t* data = nullptr;
  const std::size_t size = WebPEncodeLosslessRGBA(rgba.data(), width, height, 4 * width, &data);
  const std::string out(reinterpret_cast<const char*>(data), size);
  WebPFree(data);
  return out;
}

/// Appends big-endian 16-bit samples.
std::string words(std::initializer_list<unsigned> values) {
  std::string out;
  for (const unsigned v : values) out += {static_cast<char>(v >> 8), static_cast<char>(v & 255u)};
  return out;
}

TEST(TextureFormats, PngOfEveryColourType) {
  expect_texels(png_bytes(2, 1, 8, 0, std::string("\0\x20\xf0", 3)), 2, {32, 32, 32, 255, 240, 240, 240, 255});
  expect_texels(png_bytes(2, 1, 8, 4, std::string("\0\x20\x40\xf0\0", 5)), 2, {32, 32, 32, 64, 240, 240, 240, 0});
  expect_texels(png_bytes(1, 2, 8, 2, std::string("\0\1\2\3\0\4\5\6", 8)), 1, {1, 2, 3, 255, 4, 5, 6, 255});
  expect_texels(png_bytes(1, 1, 8, 6, std::string("\0\1\2\3\4", 5)), 1, {1, 2, 3, 4});
}

TEST(TextureFormats, PngOfFewBits) {
  expect_texels(png_bytes(2, 1, 1, 0, std::string("\0\x40", 2)), 2, {0, 0, 0, 255, 255, 255, 255, 255});
  expect_texels(png_bytes(2, 1, 2, 0, std::string("\0\x60", 2)), 2, {85, 85, 85, 255, 170, 170, 170, 255});
  expect_texels(png_bytes(2, 1, 4, 0, std::string("\0\x3c", 2)), 2, {51, 51, 51, 255, 204, 204, 204, 255});
}

TEST(TextureFormats, PngPaletteWithAlpha) {
  const std::string palette =
      png_chunk("PLTE", std::string("\1\2\3\4\5\6\7\x8\x9", 9)) + png_chunk("tRNS", std::string("\xff\x80", 2));
  const Pixels expected = {7, 8, 9, 255, 4, 5, 6, 128, 1, 2, 3, 255};
  expect_texels(png_bytes(3, 1, 8, 3, std::string("\0\2\1\0", 4), palette), 3, expected);
  expect_texels(png_bytes(3, 1, 2, 3, std::string("\0\x90", 2), palette), 3, expected);
}

TEST(TextureFormats, PngTransparentColour) {
  expect_texels(png_bytes(2, 1, 8, 0, std::string("\0\x20\xf0", 3), png_chunk("tRNS", std::string("\0\x20", 2))), 2,
                {32, 32, 32, 0, 240, 240, 240, 255});
  expect_texels(
      png_bytes(2, 1, 16, 0, std::string(1, '\0') + words({0x1234, 0x1235}), png_chunk("tRNS", words({0x1234}))), 2,
      {18, 18, 18, 0, 18, 18, 18, 255});
}

TEST(TextureFormats, PngOfSixteenBits) {
  const std::string fine = png_bytes(1, 1, 16, 6, std::string(1, '\0') + words({0x00ff, 0x7fff, 0x8080, 0xfffe}));
  EXPECT_EQ(decode(fine).image.rgba16, (std::vector<std::uint16_t>{0x00ff, 0x7fff, 0x8080, 0xfffe}));
  EXPECT_TRUE(decode(png_bytes(1, 1, 8, 6, std::string("\0\1\2\3\4", 5))).image.rgba16.empty());
  // Nearest to v / 257: 0x00ff is 0.99, 0x7fff is 127.5 - 0.002, 0x8080 is 128.
  expect_texels(fine, 1, {1, 127, 128, 255});
  expect_texels(png_bytes(1, 1, 16, 2, std::string(1, '\0') + words({0x01ff, 0xffff, 0x0080})), 1, {2, 255, 0, 255});
  expect_texels(png_bytes(1, 1, 16, 4, std::string(1, '\0') + words({0x3fff, 0xbfff})), 1, {64, 64, 64, 191});
}

TEST(TextureFormats, PngInterlaced) {
  // 3 x 3: pass 1 has (0, 0); pass 4 none; pass 5 (0, 2), (2, 2); pass 6 (1, 0), (1, 2); pass 7 row 1; pass 4 (2, 0).
  std::string rows;
  const auto row = [&rows](std::initializer_list<int> values) {
    rows.push_back('\0');
    for (const int v : values) rows.push_back(static_cast<char>(v));
  };
  row({0});
  row({2});
  row({20, 22});
  row({1});
  row({21});
  row({10, 11, 12});
  Pixels expected;
  for (const int v : {0, 1, 2, 10, 11, 12, 20, 21, 22}) {
    for (int c = 0; c < 3; ++c) expected.push_back(static_cast<std::uint8_t>(v));
    expected.push_back(255);
  }
  expect_texels(png_bytes(3, 3, 8, 0, rows, {}, true), 3, expected);
}

/// glTF 2.0, 3.8.1: colour space information (gAMA, cHRM, sRGB, iCCP) is ignored.
TEST(TextureFormats, PngColourSpaceIsIgnored) {
  std::string gamma;
  test::put_big_endian(100000, &gamma);
  const std::string extra = png_chunk("gAMA", gamma) + png_chunk("sRGB", std::string(1, '\0')) +
                            png_chunk("iCCP", "p" + std::string(2, '\0') + test::zlib_stored("no profile")) +
                            png_chunk("tEXt", std::string("Title\0x", 7));
  expect_texels(png_bytes(1, 1, 8, 2, std::string("\0\x40\x80\xc0", 4), extra), 1, {64, 128, 192, 255});
}

TEST(TextureFormats, JpegGreyIsExact) {
  for (const bool progressive : {false, true}) {
    const Decoded out = decode(jpeg_bytes({{40}, {200}}, progressive));
    ASSERT_EQ(out.image.width, 16);
    ASSERT_EQ(out.image.height, 8);
    for (std::size_t i = 0; i < 128; ++i)
      for (std::size_t c = 0; c < 4; ++c)
        ASSERT_EQ(out.image.rgba[4 * i + c], c == 3 ? 255 : i % 16 < 8 ? 40 : 200) << i;
  }
}

void expect_near(const Decoded& out, std::size_t texel, std::array<int, 3> expected) {
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(out.image.rgba[4 * texel + c], expected[c], 2) << texel << ", " << c;
  EXPECT_EQ(out.image.rgba[4 * texel + 3], 255);
}

TEST(TextureFormats, JpegColours) {
  for (const bool progressive : {false, true}) {
    // JFIF: R = Y + 1.402 (Cr - 128), G = Y - 0.344136 (Cb - 128) - 0.714136 (Cr - 128), B = Y + 1.772 (Cb - 128).
    const Decoded out = decode(jpeg_bytes({{100, 148, 88}, {150, 128, 128}}, progressive));
    expect_near(out, 0, {44, 122, 135});
    expect_near(out, 127, {150, 150, 150});
    // Adobe's transform 0 is RGB.
    expect_near(decode(jpeg_bytes({{10, 120, 230}}, progressive, 0)), 5, {10, 120, 230});
  }
}

TEST(TextureFormats, JpegCmykIsConvertedWithANote) {
  // Adobe stores 255 - C, 255 - M, 255 - Y, 255 - K.
  const Decoded cmyk = decode(jpeg_bytes({{200, 100, 50, 204}}, false, 0));
  expect_near(cmyk, 9, {160, 80, 40});
  ASSERT_EQ(cmyk.notes.size(), 1u);
  EXPECT_NE(cmyk.notes[0].find("CMYK"), std::string::npos);
  // Transform 2, YCCK: the converted colour is C, M, Y where 255 - C is stored.
  const Decoded ycck = decode(jpeg_bytes({{100, 148, 88, 255}}, false, 2));
  expect_near(ycck, 9, {255 - 44, 255 - 122, 255 - 135});
  EXPECT_EQ(ycck.notes.size(), 1u);
  EXPECT_NE(message_of<Error>([] { decode(jpeg_bytes({{1, 2, 3, 4}})); }).find("four components"), std::string::npos);
}

TEST(TextureFormats, AJpegSegmentWithoutALengthIsRefused) {
  std::string bytes = jpeg_bytes({{1, 2, 3}}, false, 0);
  bytes[5] = 0;  // of Adobe's marker
  EXPECT_NE(message_of<Error>([&] { decode(bytes); }).find("damaged JPEG"), std::string::npos);
}

TEST(TextureFormats, WebpLosslessWithAlpha) {
  Pixels rgba;
  for (int i = 0; i < 4 * 5 * 3; ++i) rgba.push_back(static_cast<std::uint8_t>(17 * i + 40));
  for (std::size_t i = 3; i < rgba.size(); i += 4) rgba[i] = static_cast<std::uint8_t>(std::max<int>(rgba[i], 1));
  expect_texels(webp_bytes(rgba, 5, 3), 5, rgba);
}

TEST(TextureFormats, WebpLossyIsNear) {
  const Pixels rgb(3 * 16 * 16, 90);
  std::uint8_t* data = nullptr;
  const std::size_t size = WebPEncodeRGB(rgb.data(), 16, 16, 48, 90.0f, &data);
  const Decoded out = decode(std::string(reinterpret_cast<const char*>(data), size));
  WebPFree(data);
  expect_near(out, 100, {90, 90, 90});
}

std::vector<std::string> samples() {
  std::string rows;
  for (int y = 0; y < 20; ++y) {
    rows.push_back('\0');
    for (int x = 0; x < 60; ++x) rows.push_back(static_cast<char>(x * y));
  }
  Pixels rgba;
  for (int i = 0; i < 4 * 20 * 20; ++i) rgba.push_back(static_cast<std::uint8_t>(i * i / 7 | 1));
  std::vector<std::vector<int>> blocks;
  for (int i = 0; i < 20; ++i) blocks.push_back({i * 11, 255 - i * 10, i * 7 % 256});
  return {png_bytes(20, 20, 8, 2, rows), jpeg_bytes(blocks), jpeg_bytes(blocks, true), webp_bytes(rgba, 20, 20)};
}

TEST(TextureFormats, CutAtEveryLengthIsRefused) {
  for (const std::string& whole : samples()) {
    EXPECT_NO_THROW(decode(whole));
    for (std::size_t size = 0; size < whole.size(); ++size) {
      TextureImage image;
      std::vector<std::string> notes;
      try {
        decode_texture(as_bytes(whole.substr(0, size)), &image, &notes);
        ADD_FAILURE() << texture_format_name(as_bytes(whole)) << " is accepted with " << size << " of " << whole.size();
      } catch (const Error& e) {
        ASSERT_EQ(std::string(e.what()).find('\n'), std::string::npos);
        ASSERT_EQ(image.width, 0);
        ASSERT_TRUE(image.rgba.empty());
      }
    }
  }
}

TEST(TextureFormats, ADamagedPngIsRefused) {
  const std::string whole = samples()[0];
  for (std::size_t i = 41; i < whole.size() - 12; i += 13) {  // within IDAT
    std::string bytes = whole;
    bytes[i] = static_cast<char>(bytes[i] ^ 4);
    EXPECT_THROW(decode(bytes), Error) << i;
  }
}

/// Refused by what it says of itself, before anything is decoded.
TEST(TextureFormats, APngThatIsTooLargeIsRefusedByItsSize) {
  for (const std::array<std::uint32_t, 2> size : {std::array{30000u, 30000u}, {2000000000u, 2u}, {65536u, 65536u}}) {
    std::string header;
    for (const std::uint32_t side : size)
      for (const int shift : {24, 16, 8, 0}) header += static_cast<char>(side >> shift & 255u);
    header += std::string("\x08\x02\0\0\0", 5);
    const std::string png =
        "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", header) + png_chunk("IDAT", "x") + png_chunk("IEND", "");
    const std::string message = message_of<Error>([&] { decode(png); });
    EXPECT_NE(message.find(std::to_string(size[0]) + " x "), std::string::npos) << message;
  }
}

TEST(TextureFormats, AJpegWithoutItsHuffmanTablesIsRefused) {
  std::string bytes = jpeg_bytes({{1, 2, 3}});
  for (std::size_t table = bytes.find("\xff\xc4"); table != std::string::npos; table = bytes.find("\xff\xc4"))
    bytes[table + 1] = '\xfe';  // a comment
  EXPECT_NE(message_of<Error>([&] { decode(bytes); }).find("cannot be decoded"), std::string::npos);
}

/// What hides nothing of the image does not lose it.
TEST(TextureFormats, HarmlessOdditiesOfAJpegKeepTheImage) {
  std::string bytes = jpeg_bytes({{70}});
  bytes.insert(bytes.rfind("\xff\xd9"), std::string(40, 'a'));
  const Decoded stray = decode(bytes);
  EXPECT_EQ(stray.image.rgba[0], 70);
  ASSERT_EQ(stray.notes.size(), 1u);
  bytes = jpeg_bytes({{70}});
  const std::size_t scan = bytes.rfind("\xff\xda");
  const auto parts = static_cast<std::size_t>(bytes[scan + 4]);
  bytes[scan + 6 + 2 * parts] = 0;  // Se, 63 in baseline images
  EXPECT_EQ(decode(bytes).image.rgba[0], 70);
}

TEST(TextureFormats, BytesBetweenTheSegmentsOfAJpegAreSkippedWithANote) {
  std::string bytes = jpeg_bytes({{70}});
  bytes.insert(bytes.find("\xff\xc0"), "abc");
  const Decoded out = decode(bytes);
  EXPECT_EQ(out.image.rgba[0], 70);
  ASSERT_EQ(out.notes.size(), 1u);
  EXPECT_NE(out.notes[0].find("superfluous bytes"), std::string::npos);
  bytes = jpeg_bytes({{70}}, true);
  bytes.insert(bytes.rfind("\xff\xda"), std::string(40, 'a'));
  EXPECT_NE(message_of<Error>([&] { decode(bytes); }).find("extraneous bytes"), std::string::npos);
}

TEST(TextureFormats, MessagesAreOneLine) {
  const std::string bytes = png_bytes(1, 1, 8, 0, std::string("\0\7", 2), png_chunk("ID\nT", ""));
  const std::string message = message_of<Error>([&] { decode(bytes); });
  EXPECT_NE(message.find("ID?T"), std::string::npos) << message;
}

TEST(TextureFormats, OtherFormatsAreNamed) {
  EXPECT_NE(message_of<Error>([] { decode("GIF89a"); }).find("not a PNG, JPEG or WebP image but GIF"),
            std::string::npos);
  EXPECT_NE(message_of<Error>([] { decode("\xabKTX 20\xbb\r\n\x1a\n"); }).find("KTX2"), std::string::npos);
  EXPECT_NE(message_of<Error>([] { decode(std::string(500, 'x')); }).find("not a PNG"), std::string::npos);
  EXPECT_NE(message_of<Error>([] { decode(""); }).find("not a PNG"), std::string::npos);
}

}  // namespace
}  // namespace maquette
