// What the header of a Radiance picture means.
#include <gtest/gtest.h>

#include <glm/glm.hpp>

#include "scenes/environment.h"
#include "scenes/error.h"
#include "scenes/image_io.h"
#include "scenes/luminance.h"
#include "tests/scenes/temporary_folder.h"

namespace maquette {
namespace {

using test::message_of;

class ImageRadiance : public test::TemporaryFolder {
 protected:
  /// One texel (1, 0.5, 0.25) under the given header lines.
  glm::vec3 texel_under(const std::string& lines) {
    warnings_.clear();
    const Image image = load_hdr_image(file_with(lines), &warnings_);
    return {image.at(0, 0, 0), image.at(0, 0, 1), image.at(0, 0, 2)};
  }
  std::string file_with(const std::string& lines) const {
    return write("a.hdr", "#?RADIANCE\n" + lines + "\n-Y 1 +X 1\n" + std::string("\x80\x40\x20\x81", 4));
  }
  std::vector<std::string> warnings_;
};

void expect_colour(const glm::vec3& found, const glm::vec3& expected, float tolerance = 1e-6f) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], tolerance * std::max(1.0f, expected[c])) << c;
}

TEST_F(ImageRadiance, ExposureAndColourCorrectionAreDividedOut) {
  const std::string format = "FORMAT=32-bit_rle_rgbe\n";
  expect_colour(texel_under(format), {1, 0.5f, 0.25f});
  expect_colour(texel_under(format + "EXPOSURE=0.5\n"), {2, 1, 0.5f});
  expect_colour(texel_under(format + "EXPOSURE= 5.000000e-01\nEXPOSURE=0.25\r\n"), {8, 4, 2});
  expect_colour(texel_under("COLORCORR=0.5 1 2\n" + format), {2, 0.5f, 0.125f});
  expect_colour(texel_under("COLORCORR=0.5 1 2\n" + format + "COLORCORR= 2 2\t4\nEXPOSURE=+2\n"),
                {0.5f, 0.125f, 1 / 64.0f});
  // Lines with a tab belong to the pictures that this one was made of.
  expect_colour(texel_under(format + "\tEXPOSURE=0.5\n# EXPOSURE=3\nVIEW= -vtl\n"), {1, 0.5f, 0.25f});
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(ImageRadiance, PrimariesAreConverted) {
  // ITU-R BT.2087.
  const glm::vec3 rgb(1, 0.5f, 0.25f);
  const glm::vec3 rec709 = glm::vec3(1.6605f, -0.1246f, -0.0182f) * rgb.x +
                           glm::vec3(-0.5876f, 1.1329f, -0.1006f) * rgb.y +
                           glm::vec3(-0.0728f, -0.0083f, 1.1187f) * rgb.z;
  const std::string rec2020 = "PRIMARIES=0.708 0.292 0.170 0.797 0.131 0.046 0.3127 0.3290\n";
  expect_colour(texel_under(rec2020), rec709, 2e-4f);
  // Exposure and correction were applied to the stored components.
  expect_colour(texel_under(rec2020 + "EXPOSURE=0.5\nCOLORCORR=1 0.5 1\n"),
                2.0f * (rec709 + 0.5f * glm::vec3(-0.5876f, 1.1329f, -0.1006f)), 3e-4f);
  expect_colour(texel_under("PRIMARIES=0.640 0.330 0.300 0.600 0.150 0.060 0.3127 0.3290\n"), rgb, 0.0f);
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(ImageRadiance, WhiteStaysWhiteUnderAnotherWhitePoint) {
  const std::string file =
      write("w.hdr", "#?RADIANCE\nPRIMARIES= 0.64 0.33 0.29 0.60 0.15 0.06 0.333 0.333\n\n-Y 1 +X 1\n" +
                         std::string("\x80\x80\x80\x81", 4));
  const Image image = load_hdr_image(file);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(image.at(0, 0, c), 1.0f, 1e-5f);
}

TEST_F(ImageRadiance, LinesWithoutAMeaningAreWarnedOf) {
  for (const char* line : {"EXPOSURE=0", "EXPOSURE=-1", "EXPOSURE=nan", "EXPOSURE=", "COLORCORR=1 2", "COLORCORR=1 0 1",
                           "PRIMARIES=1 2 3", "PRIMARIES=0 0 0 0 0 0 0 0", "GAMMA=2.2", "GAMMA=x"}) {
    expect_colour(texel_under(line + std::string("\n")), {1, 0.5f, 0.25f}, 0.0f);
    ASSERT_EQ(warnings_.size(), 1u) << line;
    EXPECT_NE(warnings_[0].find(std::string(line).substr(0, 5)), std::string::npos) << warnings_[0];
    EXPECT_EQ(load_environment(path("a.hdr")).warnings, warnings_);
  }
  texel_under("GAMMA=1.0\n");
  EXPECT_TRUE(warnings_.empty());
  texel_under("GAMMA=" + std::string(3000, '7') + "\n");
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_LT(warnings_[0].size(), 120u);
}

TEST_F(ImageRadiance, XyzIsRefused) {
  const std::string message = message_of<Error>([&] { load_hdr_image(file_with("FORMAT=32-bit_rle_xyze\n")); });
  EXPECT_NE(message.find("32-bit_rle_xyze is not 32-bit_rle_rgbe"), std::string::npos) << message;
}

/// The picture with texel (x, y) = (1 + x, 1 + y), written line by line as each of the eight orientations says; as
/// plain texels and, for lines of 8 or more, in the run-length encoding.
TEST_F(ImageRadiance, AllOrientationsGiveOnePicture) {
  for (const int width : {3, 11}) {
    const int height = width == 3 ? 300 : 9;
    for (int k = 0; k < 8; ++k) {
      const bool columns = k & 1, from_bottom = k & 2, from_right = k & 4;
      const std::string y_axis = std::string(from_bottom ? "+Y " : "-Y ") + std::to_string(height);
      const std::string x_axis = std::string(from_right ? "-X " : "+X ") + std::to_string(width);
      const std::string size = columns ? x_axis + " " + y_axis : y_axis + " " + x_axis;
      const int lines = columns ? width : height, length = columns ? height : width;
      std::string bytes = "#?RADIANCE\n\n" + size + "\n";
      for (int line = 0; line < lines; ++line) {
        std::string planes[4];
        std::string texels;
        for (int i = 0; i < length; ++i) {
          const int file_x = columns ? line : i, file_y = columns ? i : line;
          const int x = from_right ? width - 1 - file_x : file_x, y = from_bottom ? height - 1 - file_y : file_y;
          const unsigned char texel[4] = {static_cast<unsigned char>(64 + x), static_cast<unsigned char>(y % 128), 128,
                                          static_cast<unsigned char>(129 + y / 128)};
          for (int c = 0; c < 4; ++c) {
            planes[c] += static_cast<char>(texel[c]);
            texels += static_cast<char>(texel[c]);
          }
        }
        if (width == 3) {
          bytes += texels;
          continue;
        }
        bytes += std::string("\2\2\0", 3) + static_cast<char>(length);
        for (const std::string& plane : planes) bytes += static_cast<char>(length) + plane;
      }
      const Image image = load_hdr_image(write("a.hdr", bytes));
      ASSERT_EQ(image.width, width) << size;
      ASSERT_EQ(image.height, height) << size;
      for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
          const float scale = std::exp2(static_cast<float>(y / 128) - 7.0f);
          ASSERT_EQ(image.at(x, y, 0), static_cast<float>(64 + x) * scale) << size << ": " << x << ", " << y;
          ASSERT_EQ(image.at(x, y, 1), static_cast<float>(y % 128) * scale) << size << ": " << x << ", " << y;
        }
      }
    }
  }
}

TEST_F(ImageRadiance, SizeLinesThatAreNoneAreQuoted) {
  for (const char* line : {"-Y 1 -Y 1", "Y 1 X 1", "-Y 1", "-Z 1 +X 1", "-Y one +X 1", "-Y 1 +X"}) {
    const std::string file = write("a.hdr", std::string("#?RADIANCE\n\n") + line + "\nabcd");
    EXPECT_NE(message_of<Error>([&] { load_hdr_image(file); }).find(line), std::string::npos) << line;
  }
}

}  // namespace
}  // namespace maquette
