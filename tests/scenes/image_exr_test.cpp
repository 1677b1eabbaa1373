// What the channels, parts, windows and colour spaces of an EXR file mean.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfEnvmapAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "scenes/environment.h"
#include "scenes/error.h"
#include "scenes/image_color.h"
#include "scenes/image_io.h"
#include "scenes/luminance.h"
#include "tests/scenes/temporary_folder.h"

namespace maquette {
namespace {

using test::message_of;
using Texel = std::function<float(int x, int y)>;

struct TestChannel {
  std::string name;
  Texel value;
  int sampling = 1;
};

struct TestPart {
  std::string name;
  std::vector<TestChannel> channels;
  std::string view = {};
};

Texel constant(float value) {
  return [value](int, int) { return value; };
}

/// Y, RY and BY of one Rec.709 colour.
std::vector<TestChannel> chroma_of(const glm::vec3& rgb, int sampling) {
  // Y of the primaries and the white of Rec.709, exactly as OpenEXR does.
  const float y = glm::dot(rgb, glm::vec3(0.2126390f, 0.7151687f, 0.0721923f));
  return {{"Y", constant(y)}, {"RY", constant((rgb.x - y) / y), sampling}, {"BY", constant((rgb.z - y) / y), sampling}};
}

std::vector<TestChannel> rgb_of(const glm::vec3& rgb, const std::string& prefix = {}) {
  return {{prefix + "R", constant(rgb.x)}, {prefix + "G", constant(rgb.y)}, {prefix + "B", constant(rgb.z)}};
}

class ImageExr : public test::TemporaryFolder {
 protected:
  /// Writes float parts; the values are functions of absolute pixel coordinates.
  std::string write_parts(const std::vector<TestPart>& parts) const {
    std::vector<Imf::Header> headers;
    for (const TestPart& part : parts) {
      Imf::Header header(display_, data_);
      header.compression() = Imf::ZIP_COMPRESSION;
      if (parts.size() > 1) {
        header.setName(part.name);
        header.setType(Imf::SCANLINEIMAGE);
      }
      if (!part.view.empty()) header.setView(part.view);
      if (chromaticities_) Imf::addChromaticities(header, *chromaticities_);
      if (cube_) Imf::addEnvmap(header, Imf::ENVMAP_CUBE);
      for (const TestChannel& c : part.channels)
        header.channels().insert(c.name, Imf::Channel(Imf::FLOAT, c.sampling, c.sampling));
      headers.push_back(header);
    }
    const std::string file_name = path("a.exr");
    if (parts.size() == 1) {
      Imf::OutputFile file(file_name.c_str(), headers[0]);
      write_channels(parts[0], &file);
    } else {
      Imf::MultiPartOutputFile file(file_name.c_str(), headers.data(), static_cast<int>(headers.size()));
      for (std::size_t p = 0; p < parts.size(); ++p) {
        Imf::OutputPart part(file, static_cast<int>(p));
        write_channels(parts[p], &part);
      }
    }
    return file_name;
  }

  template <class File>
  void write_channels(const TestPart& part, File* file) const {
    Imf::FrameBuffer buffer;
    std::vector<std::vector<float>> values;
    const int width = data_.max.x - data_.min.x + 1, height = data_.max.y - data_.min.y + 1;
    for (const TestChannel& c : part.channels) {
      std::vector<float>& plane = values.emplace_back();
      for (int y = data_.min.y; y <= data_.max.y; y += c.sampling)
        for (int x = data_.min.x; x <= data_.max.x; x += c.sampling) plane.push_back(c.value(x, y));
      const auto columns = static_cast<std::size_t>((width + c.sampling - 1) / c.sampling);
      buffer.insert(c.name, Imf::Slice::Make(Imf::FLOAT, plane.data(), data_.min, width, height, sizeof(float),
                                             columns * sizeof(float), c.sampling, c.sampling));
    }
    file->setFrameBuffer(buffer);
    file->writePixels(height);
  }

  void expect_constant(const std::vector<TestPart>& parts, const glm::vec3& rgb, float tolerance = 1e-6f) {
    warnings_.clear();
    const Image image = load_hdr_image(write_parts(parts), &warnings_);
    ASSERT_EQ(image.width, display_.max.x + 1);
    ASSERT_EQ(image.height, display_.max.y + 1);
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x)
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(image.at(x, y, c), rgb[c], tolerance) << x << ", " << y << ", " << c;
  }

  Imath::Box2i display_{{0, 0}, {15, 7}}, data_{{0, 0}, {15, 7}};
  std::optional<Imf::Chromaticities> chromaticities_;
  bool cube_ = false;
  std::vector<std::string> warnings_;
};

const glm::vec3 kColour(0.2f, 0.5f, 0.8f);

TEST_F(ImageExr, APictureIsItsDisplayWindow) {
  const std::vector<TestPart> parts = {{"",
                                        {{"R", [](int x, int) { return static_cast<float>(x); }},
                                         {"G", [](int, int y) { return static_cast<float>(y); }},
                                         {"B", constant(3.0f)},
                                         {"A", constant(1.0f)}}}};
  // Cropped, overscan on all sides, overlapping at a corner, apart; with more rows than one strip.
  const Imath::Box2i windows[] = {{{2, 1}, {5, 2}}, {{-3, -300}, {19, 900}}, {{9, 500}, {40, 700}}, {{50, 0}, {60, 9}}};
  display_ = {{0, 0}, {15, 599}};
  for (const Imath::Box2i& window : windows) {
    data_ = window;
    const Image image = load_hdr_image(write_parts(parts));
    ASSERT_EQ(image.width, 16);
    ASSERT_EQ(image.height, 600);
    for (int y = 0; y < 600; ++y) {
      for (int x = 0; x < 16; ++x) {
        const bool inside = window.intersects(Imath::V2i(x, y));
        ASSERT_EQ(image.at(x, y, 0), inside ? static_cast<float>(x) : 0.0f) << x << ", " << y;
        ASSERT_EQ(image.at(x, y, 1), inside ? static_cast<float>(y) : 0.0f) << x << ", " << y;
        ASSERT_EQ(image.at(x, y, 2), inside ? 3.0f : 0.0f);
        ASSERT_EQ(image.at(x, y, 3), inside ? 1.0f : 0.0f);
      }
    }
  }
}

// OpenEXR reserves the memory that an attribute asks for before it reads it.
TEST_F(ImageExr, AnAttributeIsNoLongerThanTheFile) {
  save_exr(path("a.exr"), Image(4, 4, 3, 0.5f), {{"maquette.note", "hello"}});
  std::string bytes = read(path("a.exr"));
  const std::size_t at = bytes.find("maquette.note");
  ASSERT_NE(at, std::string::npos);
  const std::size_t size = at + std::string("maquette.note").size() + 1 + std::string("string").size() + 1;
  ASSERT_EQ(bytes[size], 5);
  EXPECT_NO_THROW(load_hdr_image(path("a.exr")));
  for (const char* length : {"\xff\xff\xff\x7f", "\xff\xff\xff\xff", "\x00\x00\x00\x40"}) {
    bytes.replace(size, 4, length, 4);
    const std::string file = write("b.exr", bytes);
    const std::string said = test::message_of<Error>([&] { load_hdr_image(file); });
    EXPECT_NE(said.find("longer than the file"), std::string::npos) << said;
  }
}

// OpenEXR reads attributes by their types and goes on where they end, whatever length the header says.
TEST_F(ImageExr, AnAttributeHasTheLengthOfItsType) {
  save_exr(path("a.exr"), Image(4, 4, 3, 0.5f));
  const std::string whole = read(path("a.exr"));
  for (const std::string& attribute : {std::string("channels\0chlist\0", 16), std::string("dataWindow\0box2i\0", 17),
                                      std::string("lineOrder\0lineOrder\0", 20)}) {
    const std::size_t at = whole.find(attribute);
    ASSERT_NE(at, std::string::npos);
    for (const int more : {1, -1}) {
      std::string bytes = whole;
      char& length = bytes[at + attribute.size()];
      length = static_cast<char>(length + more);
      const std::string file = write("b.exr", bytes);
      const std::string said = test::message_of<Error>([&] { load_hdr_image(file); });
      EXPECT_NE(said.find("length of its type"), std::string::npos) << said;
    }
  }
}

TEST_F(ImageExr, TheDisplayWindowMayBeginAnywhere) {
  display_ = {{-4, 10}, {3, 13}};
  data_ = {{-2, 9}, {3, 11}};
  const Image image =
      load_hdr_image(write_parts({{"", {{"Y", [](int x, int y) { return static_cast<float>(100 * y + x); }}}}}));
  ASSERT_EQ(image.width, 8);
  ASSERT_EQ(image.height, 4);
  EXPECT_EQ(image.at(1, 0, 0), 0.0f);
  EXPECT_EQ(image.at(2, 0, 1), 998.0f);
  EXPECT_EQ(image.at(7, 1, 2), 1103.0f);
  EXPECT_EQ(image.at(7, 2, 0), 0.0f);
}

TEST_F(ImageExr, AnEnvironmentIsItsDataWindow) {
  data_ = {{4, 2}, {11, 5}};
  const Environment e = load_environment(write_parts({{"", rgb_of(kColour)}}));
  EXPECT_EQ(e.width, 8);
  EXPECT_EQ(e.height, 4);
  EXPECT_TRUE(e.warnings.empty());
  for (const glm::vec3& rgb : e.rgb) EXPECT_EQ(rgb, kColour);
}

TEST_F(ImageExr, ACubeMapIsNoLatitudeLongitudeMap) {
  cube_ = true;
  const std::string file = write_parts({{"", rgb_of(kColour)}});
  EXPECT_NE(message_of<Error>([&] { load_environment(file); }).find("cube map"), std::string::npos);
  EXPECT_EQ(load_hdr_image(file).width, 16);
}

TEST_F(ImageExr, AnAbsurdDisplayWindowIsRefused) {
  display_ = {{0, 0}, {2000000, 7}};
  EXPECT_THROW(load_hdr_image(write_parts({{"", rgb_of(kColour)}})), Error);
}

TEST_F(ImageExr, LuminanceAndChromaInEveryLayout) {
  for (const int sampling : {1, 2}) {
    expect_constant({{"", chroma_of(kColour, sampling)}}, kColour, 2e-6f);
    expect_constant({{"colour", chroma_of(kColour, sampling)}, {"depth", {{"Z", constant(9)}}}}, kColour, 2e-6f);
    EXPECT_TRUE(warnings_.empty());
  }
  display_ = data_ = {{0, 0}, {301, 699}};  // several strips
  expect_constant({{"", chroma_of(kColour, 2)}}, kColour, 2e-6f);
}

TEST_F(ImageExr, ChromaIsNotHeldInHalfPrecision) {
  const glm::vec3 bright(200000.0f, 100001.0f, 50000.0f);
  for (const int sampling : {1, 2}) expect_constant({{"", chroma_of(bright, sampling)}}, bright, 0.5f);
}

/// OpenEXR's own reader is the reference for pictures that its own writer has made.
TEST_F(ImageExr, ChromaAgreesWithOpenExr) {
  constexpr int kWidth = 90, kHeight = 310;
  std::vector<Imf::Rgba> texels;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      texels.emplace_back(1.0f + 0.3f * std::sin(0.2f * static_cast<float>(x)),
                          1.0f + 0.3f * std::cos(0.15f * static_cast<float>(y)),
                          1.0f + 0.2f * std::sin(0.1f * static_cast<float>(x + y)));
  {
    Imf::RgbaOutputFile file(path("yc.exr").c_str(), kWidth, kHeight, Imf::WRITE_YC);
    file.setFrameBuffer(texels.data(), 1, kWidth);
    file.writePixels(kHeight);
  }
  Imf::RgbaInputFile file(path("yc.exr").c_str());
  file.setFrameBuffer(texels.data(), 1, kWidth);
  file.readPixels(0, kHeight - 1);
  const Image image = load_hdr_image(path("yc.exr"));
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Imf::Rgba& expected = texels[static_cast<std::size_t>(y * kWidth + x)];
      ASSERT_NEAR(image.at(x, y, 0), expected.r, 4e-3f) << x << ", " << y;
      ASSERT_NEAR(image.at(x, y, 1), expected.g, 4e-3f) << x << ", " << y;
      ASSERT_NEAR(image.at(x, y, 2), expected.b, 4e-3f) << x << ", " << y;
    }
  }
}

TEST_F(ImageExr, ChromaUsesTheLuminanceOfItsPrimaries) {
  chromaticities_ = Imf::Chromaticities({0.708f, 0.292f}, {0.170f, 0.797f}, {0.131f, 0.046f}, {0.3127f, 0.3290f});
  // Rec.2020: Y = 0.2627 R + 0.6780 G + 0.0593 B; ITU-R BT.2087 gives (0.8, 0.6, 0.5) in Rec.709.
  const float y = 0.26270f * 0.8f + 0.67800f * 0.6f + 0.05930f * 0.5f;
  expect_constant({{"", {{"Y", constant(y)}, {"RY", constant(0.8f / y - 1)}, {"BY", constant(0.5f / y - 1)}}}},
                  {1.6605f * 0.8f - 0.5876f * 0.6f - 0.0728f * 0.5f, -0.1246f * 0.8f + 1.1329f * 0.6f - 0.0083f * 0.5f,
                   -0.0182f * 0.8f - 0.1006f * 0.6f + 1.1187f * 0.5f},
                  3e-4f);
}

TEST_F(ImageExr, FindsThePictureAmongPartsAndLayers) {
  const std::vector<TestChannel> depth = {{"Z", constant(9)}};
  const std::vector<TestChannel> other = rgb_of({7, 7, 7});
  expect_constant({{"depth", depth}, {"colour", rgb_of(kColour)}}, kColour);
  expect_constant({{"", rgb_of(kColour, "ViewLayer.Combined.")}}, kColour);
  expect_constant({{"depth", depth}, {"rgb", rgb_of(kColour, "rgb.")}}, kColour);
  // One channel a part, in any order and with a part between them.
  expect_constant({{"b", {{"B", constant(0.8f)}}},
                   {"depth", depth},
                   {"r", {{"R", constant(0.2f)}}},
                   {"g", {{"G", constant(0.5f)}}}},
                  kColour);
  expect_constant({{"rg", {{"R", constant(0.2f)}, {"G", constant(0.5f)}}}, {"b", {{"B", constant(0.8f)}}}}, kColour);
  expect_constant({{"1", {{"beauty.R", constant(0.2f)}}},
                   {"2", {{"beauty.G", constant(0.5f)}}},
                   {"3", {{"beauty.B", constant(0.8f)}}}},
                  kColour);
  // Luminance of another part is not the picture.
  expect_constant({{"mask", {{"Y", constant(1)}}}, {"rgb", rgb_of(kColour)}}, kColour);
  EXPECT_TRUE(warnings_.empty());
  expect_constant({{"mask", {{"Y", constant(0.25f)}}}, {"depth", depth}}, glm::vec3(0.25f));
  EXPECT_TRUE(warnings_.empty());
  // Plain channels of the only part are the picture; its layers need no warning.
  std::vector<TestChannel> layered = rgb_of({7, 7, 7}, "Albedo.");
  for (const TestChannel& c : rgb_of(kColour)) layered.push_back(c);
  expect_constant({{"", layered}}, kColour);
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(ImageExr, TheFirstOfSeveralPicturesIsReadWithAWarning) {
  const std::vector<TestChannel> other = rgb_of({7, 7, 7});
  expect_constant({{"left", rgb_of(kColour)}, {"right", other}}, kColour);
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_EQ(warnings_[0], "holds 2 pictures (left, right): \"left\" is read");
  // Each channel in its own part: colours of the two views are not mixed.
  expect_constant({{"a.R", {{"R", constant(0.2f)}}},
                   {"b.R", {{"R", constant(7)}}},
                   {"b.G", {{"G", constant(7)}}},
                   {"a.G", {{"G", constant(0.5f)}}},
                   {"b.B", {{"B", constant(7)}}},
                   {"a.B", {{"B", constant(0.8f)}}}},
                  kColour);
  expect_constant({{"1", {{"R", constant(0.2f)}}, "left"},
                   {"2", {{"R", constant(7)}, {"G", constant(7)}}, "right"},
                   {"3", {{"G", constant(0.5f)}, {"B", constant(0.8f)}}, "left"},
                   {"4", {{"B", constant(7)}}, "right"}},
                  kColour);
  const Environment e = load_environment(path("a.exr"));
  ASSERT_EQ(e.warnings.size(), 1u);
  EXPECT_EQ(e.warnings[0], "holds 2 pictures (left, right): \"left\" is read");
}

TEST_F(ImageExr, ChannelsThatMakeNoPictureAreNamed) {
  const auto refused = [&](const std::vector<TestPart>& parts, const std::string& found) {
    const std::string message = message_of<Error>([&] { load_hdr_image(write_parts(parts)); });
    EXPECT_NE(message.find(found), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    EXPECT_LT(message.size(), 400u);
  };
  refused({{"", {{"R", constant(1)}}}}, "(found: R)");
  refused({{"", {{"Y", constant(1)}, {"RY", constant(0)}}}}, "(found: RY, Y)");
  refused({{"a", {{"R", constant(1)}}}, {"b", {{"N.X", constant(0)}, {"N.Y", constant(0), 1}, {"N.RY", constant(0)}}}},
          "(found: R; N.RY, N.X, N.Y)");
  refused({{"", {{"left.R", constant(1)}, {"right.G", constant(1)}, {"right.B", constant(1)}}}}, "found: left.R");
  refused({{"", {{std::string(200, 'x'), constant(1)}}}}, "xxx...");
  std::vector<TestChannel> coarse = rgb_of(kColour);
  coarse[1].sampling = 2;
  refused({{"", coarse}}, "channel G is subsampled by 2 x 2");
  refused({{"", chroma_of(kColour, 4)}}, "Y is subsampled by 4 x 4");
}

TEST_F(ImageExr, ChromaticitiesAreConverted) {
  struct Case {
    Imf::Chromaticities chromaticities;
    float rows[3][3];
  };
  // Rec.2020: ITU-R BT.2087. ACES AP0: the matrix of the ACES reference code, adapted by Bradford.
  const Case cases[] = {
      {{{0.708f, 0.292f}, {0.170f, 0.797f}, {0.131f, 0.046f}, {0.3127f, 0.3290f}},
       {{1.6605f, -0.5876f, -0.0728f}, {-0.1246f, 1.1329f, -0.0083f}, {-0.0182f, -0.1006f, 1.1187f}}},
      {{{0.7347f, 0.2653f}, {0.0f, 1.0f}, {0.0001f, -0.0770f}, {0.32168f, 0.33767f}},
       {{2.52169f, -1.13413f, -0.38756f}, {-0.27648f, 1.37272f, -0.09624f}, {-0.01538f, -0.15298f, 1.16835f}}}};
  for (const Case& c : cases) {
    chromaticities_ = c.chromaticities;
    for (int k = 0; k < 3; ++k) {
      glm::vec3 primary(0.0f), expected;
      primary[k] = 2.0f;
      for (int row = 0; row < 3; ++row) expected[row] = 2.0f * c.rows[row][k];
      expect_constant({{"", rgb_of(primary)}}, expected, 3e-4f);
    }
    expect_constant({{"", rgb_of(glm::vec3(5.0f))}}, glm::vec3(5.0f), 1e-5f);
    EXPECT_TRUE(warnings_.empty());
  }
}

TEST_F(ImageExr, ChromaticitiesOfRec709ChangeNoBit) {
  chromaticities_ = Imf::Chromaticities();
  expect_constant({{"", rgb_of(kColour)}}, kColour, 0.0f);
}

TEST_F(ImageExr, ChromaticitiesWithoutAMeaningAreWarnedOf) {
  const float nan = std::nanf("");
  const Imf::Chromaticities cases[] = {{{0, 0}, {0, 0}, {0, 0}, {0, 0}},
                                       {{0.64f, 0.33f}, {0.64f, 0.33f}, {0.15f, 0.06f}, {0.3127f, 0.3290f}},
                                       {{nan, 0.33f}, {0.3f, 0.6f}, {0.15f, 0.06f}, {0.3127f, 0.3290f}},
                                       {{0.64f, 0.33f}, {0.3f, 0.6f}, {0.15f, 0.06f}, {0.7f, 0.3f}}};
  for (const Imf::Chromaticities& c : cases) {
    chromaticities_ = c;
    expect_constant({{"", rgb_of(kColour)}}, kColour, 0.0f);
    ASSERT_EQ(warnings_.size(), 1u);
    EXPECT_NE(warnings_[0].find("describe no colour space"), std::string::npos);
  }
}

TEST_F(ImageExr, AnEnvironmentKeepsTheLuminanceOfColoursOutsideRec709) {
  chromaticities_ = Imf::Chromaticities({0.708f, 0.292f}, {0.170f, 0.797f}, {0.131f, 0.046f}, {0.3127f, 0.3290f});
  const Environment green = load_environment(write_parts({{"", rgb_of({0, 1, 0})}}));
  ASSERT_EQ(green.warnings.size(), 1u);
  EXPECT_NE(green.warnings[0].find("128 texels were outside the gamut"), std::string::npos) << green.warnings[0];
  for (const glm::vec3& rgb : green.rgb) {
    EXPECT_NEAR(luminance(rgb), 0.6780f, 2e-4f);
    EXPECT_GE(std::min({rgb.x, rgb.y, rgb.z}), 0.0f);
    EXPECT_GT(rgb.y, std::max(rgb.x, rgb.z));
  }
  EXPECT_TRUE(load_environment(write_parts({{"", rgb_of({0.5f, 0.6f, 0.5f})}})).warnings.empty());
}

TEST_F(ImageExr, AFileCutInTheLastPartIsRefusedOnlyWhereItIsNeeded) {
  const std::string whole =
      read(write_parts({{"rgb", rgb_of(kColour)},
                        {"depth", {{"Z", [](int x, int y) { return std::sin(static_cast<float>(7 * x + y)); }}}}}));
  const std::string cut = write("cut.exr", whole.substr(0, whole.size() - 40));
  EXPECT_EQ(load_hdr_image(cut).at(3, 3, 2), 0.8f);
  const std::string other = read(write_parts({{"depth", {{"Z", constant(1)}}}, {"rgb", rgb_of(kColour)}}));
  EXPECT_THROW(load_hdr_image(write("b.exr", other.substr(0, other.size() - 40))), Error);
}

}  // namespace
}  // namespace maquette
