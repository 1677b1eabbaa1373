#include "render/materials/texture_bandwidth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace maquette {
namespace {

/// 512 x 512, black and white stripes of `cycles` periods along u on the left half (on all of it with `whole`), grey
/// elsewhere.
TextureImage stripes(double cycles, bool whole) {
  TextureImage image;
  image.width = image.height = 512;
  image.rgba.assign(512 * 512 * 4, 255);
  for (std::size_t y = 0; y < 512; ++y) {
    for (std::size_t x = 0; x < 512; ++x) {
      const double wave =
          whole || x < 256 ? std::cos(6.283185307179586 * cycles * (static_cast<double>(x) + 0.5) / 512.0) : 0.0;
      std::fill_n(&image.rgba[4 * (y * 512 + x)], 3, static_cast<std::uint8_t>(std::lround(127.5 + 127.0 * wave)));
    }
  }
  return image;
}

TEST(TextureBandwidth, FollowsTheFrequencyOfStripes) {
  double last = 0.0;
  for (const double cycles : {24.0, 48.0, 96.0, 192.0}) {
    std::vector<float> map = compute_texture_bandwidth(stripes(cycles, true));
    std::nth_element(map.begin(), map.begin() + 128, map.end());
    const double median = static_cast<double>(map[128]);
    EXPECT_GT(median, 0.75 * cycles) << cycles;
    EXPECT_LT(median, 2.7 * cycles) << cycles;  // octave bands, whose edges overlap
    EXPECT_GT(median, last);
    last = median;
  }
}

TEST(TextureBandwidth, IsLocalAndZeroWhereNothingVaries) {
  const std::vector<float> map = compute_texture_bandwidth(stripes(96.0, false));
  ASSERT_EQ(map.size(), static_cast<std::size_t>(kTextureBandwidthSide * kTextureBandwidthSide));
  EXPECT_GT(map[8 * 16 + 4], 60.0f);
  EXPECT_LT(map[8 * 16 + 12], 1.0f);
  for (const float nu : compute_texture_bandwidth(stripes(0.0, true))) EXPECT_EQ(nu, 0.0f);
}

/// A checker of side x side texels of two values in one channel, 128 in the others.
TextureImage checker(int side, int channel, int low, int high) {
  TextureImage image;
  image.width = image.height = side;
  image.rgba.assign(static_cast<std::size_t>(4 * side * side), 128);
  for (int i = 0; i < side * side; ++i)
    image.rgba[static_cast<std::size_t>(4 * i + channel)] =
        static_cast<std::uint8_t>((i % side + i / side) % 2 == 0 ? low : high);
  return image;
}

/// As colour a checker of a third is smooth: its mean holds 95 % of its energy. As data it is not.
TEST(TextureBandwidth, OfDataIsThatOfWhatVaries) {
  for (const int side : {2, 4, 8, 16, 64, 256}) {
    for (const float nu : compute_data_bandwidth(checker(side, 1, 130, 220), 2))
      EXPECT_GE(nu, 0.45f * static_cast<float>(side));
    for (const float nu : compute_data_bandwidth(checker(side, 3, 100, 140), 8))
      EXPECT_GE(nu, 0.45f * static_cast<float>(side));
    for (const float nu : compute_data_bandwidth(checker(side, 3, 100, 140), 7)) EXPECT_EQ(nu, 0.0f);  // of others
    for (const float nu : compute_data_bandwidth(checker(side, 1, 128, 128), 15)) EXPECT_EQ(nu, 0.0f);
  }
  EXPECT_EQ(data_channels(TextureRole::base_color), 0u);
  EXPECT_EQ(data_channels(TextureRole::metallic_roughness), 6u);
  EXPECT_EQ(data_channels(TextureRole::sheen_roughness), 8u);
}

TEST(TextureBandwidth, OneTexelHasNone) {
  TextureImage image;
  image.width = image.height = 1;
  image.rgba = {1, 2, 3, 4};
  for (const float nu : compute_texture_bandwidth(image)) EXPECT_EQ(nu, 0.0f);
}

}  // namespace
}  // namespace maquette
