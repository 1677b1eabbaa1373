// How much of large images is kept, and that what is kept shows the same.
#include "scenes/texture_budget.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <random>

#include "scenes/srgb.h"
#include "tests/scenes/gltf_fixture.h"
#include "tests/scenes/texture_bytes.h"

namespace maquette {
namespace {

using test::png_chunk;

std::size_t sum_of(const std::vector<glm::ivec2>& sizes, const std::vector<int>& halvings) {
  std::size_t sum = 0;
  for (std::size_t i = 0; i < sizes.size(); ++i)
    sum += static_cast<std::size_t>(std::max(sizes[i].x >> halvings[i], sizes[i].x > 0 ? 1 : 0)) *
           static_cast<std::size_t>(std::max(sizes[i].y >> halvings[i], sizes[i].y > 0 ? 1 : 0));
  return sum;
}

TEST(TextureBudget, HalvesTheLargestUntilAllFit) {
  std::mt19937 random(11);
  for (int round = 0; round < 500; ++round) {
    std::vector<glm::ivec2> sizes(1 + random() % 20);
    for (glm::ivec2& size : sizes) size = {1 << random() % 14, random() % 8 == 0 ? 0 : 1 << random() % 14};
    const std::size_t most = std::size_t{1} << (10 + random() % 18);
    const std::vector<int> halvings = halvings_within(sizes, most);
    ASSERT_LE(sum_of(sizes, halvings), most);
    for (std::size_t i = 0; i < sizes.size(); ++i)
      for (std::size_t k = 0; k < sizes.size(); ++k) {
        ASSERT_TRUE(sizes[i] != sizes[k] || halvings[i] == halvings[k]) << "alike";
        // Nothing is made smaller than an eighth of what stays whole.
        const std::size_t kept = sum_of({sizes[i]}, {halvings[i]}), whole = sum_of({sizes[k]}, {0});
        ASSERT_TRUE(halvings[i] == 0 || halvings[k] > 0 || 8 * kept >= whole) << kept << " of " << whole;
      }
    // One halving less of all would not fit.
    std::vector<int> less = halvings;
    for (int& times : less) times = std::max(times - 1, 0);
    ASSERT_TRUE(less == halvings || sum_of(sizes, less) > most);
  }
}

TEST(TextureBudget, HalvedImagesHaveTheMeanOfTheirLight) {
  std::mt19937 random(5);
  for (const bool srgb : {false, true})
    for (const bool fine : {false, true}) {
      TextureImage image{"noise", 13, 6, std::vector<std::uint8_t>(4 * 13 * 6)};
      for (std::uint8_t& code : image.rgba) code = static_cast<std::uint8_t>(random() % 256u);
      if (fine)
        for (const std::uint8_t code : image.rgba) image.rgba16.push_back(static_cast<std::uint16_t>(257u * code));
      const auto mean = [&](const TextureImage& of, std::size_t channel) {
        double sum = 0.0;
        for (std::size_t i = channel; i < of.rgba.size(); i += 4) {
          const double value = of.rgba[i] / 255.0;
          sum += srgb && channel < 3 ? linear_from_srgb(value) : value;
        }
        return 4.0 * sum / static_cast<double>(of.rgba.size());
      };
      TextureImage halved = image;
      halve_image(&halved, 2, srgb);
      EXPECT_EQ(halved.width, 3);
      EXPECT_EQ(halved.height, 1);
      EXPECT_EQ(halved.rgba.size(), 12u);
      EXPECT_EQ(halved.rgba16.size(), fine ? 12u : 0u);
      for (std::size_t c = 0; c < 4; ++c) EXPECT_NEAR(mean(halved, c), mean(image, c), 0.006) << c << srgb << fine;
    }
}

using TextureBudgetOfFile = test::GltfFixture;

/// A white image of one bit a texel, of which only the first `height` rows are there: a few kilobytes whatever its
/// size.
std::string white_png(std::uint32_t side, std::uint32_t height) {
  std::string header;
  for (int k = 0; k < 2; ++k) test::put_big_endian(side, &header);
  header += std::string("\x01\0\0\0\0", 5);
  std::string row(1 + side / 8, '\xff'), rows;
  row[0] = '\0';
  for (std::uint32_t y = 0; y < height; ++y) rows += row;
  uLongf size = compressBound(rows.size());
  std::string packed(size, '\0');
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()), rows.size());
  packed.resize(size);
  return "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", header) + png_chunk("IDAT", packed) + png_chunk("IEND", {});
}

TEST_F(TextureBudgetOfFile, ASmallFileOfLargeImagesIsMadeSmaller) {
  add_quad();
  const std::string large = white_png(8192, 8192), huge = white_png(16384, 1);
  root_["images"] = {
      {{"bufferView", add_view(std::vector<char>(large.begin(), large.end()))}, {"mimeType", "image/png"}},
      {{"bufferView", add_view(std::vector<char>(huge.begin(), huge.end()))}, {"mimeType", "image/png"}}};
  root_["textures"] = {{{"source", 0}}, {{"source", 1}}};
  root_["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}},
                        {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 1}}}}}}};
  const Scene scene = load();
  expect_warning(scene,
                 "67 million texels together, 34 million are kept of images of so many bytes: 1 are read at half");
  expect_warning(scene, "has 16384 x 16384 texels, more than 8192 x 8192");
  EXPECT_EQ(scene.images[0].width, 4096);
  EXPECT_EQ(scene.images[0].rgba.size(), std::size_t{4} << 24);
  EXPECT_EQ(scene.images[0].rgba[12345], 255);
  EXPECT_EQ(scene.images[1].width, 0);
  EXPECT_FALSE(scene.materials[1].base_color_texture) << "left out";
}

TEST_F(TextureBudgetOfFile, ElementsThatAreReadAgainAndAgainAreRefused) {
  add_quad();
  primitive()["indices"] =
      add_accessor<std::uint8_t>(std::vector<std::uint8_t>(3'000'000, std::uint8_t{1}), 5121, "SCALAR", 1);
  for (int i = 0; i < 8; ++i) root_["meshes"].push_back(root_["meshes"][0]);
  expect_error("elements of accessors again");
}

TEST_F(TextureBudgetOfFile, MoreNodesMaterialsOrObjectsThanPossibleAreRefused) {
  add_quad();
  root_["materials"] = test::Json::array();
  for (int i = 0; i < 65536; ++i) root_["materials"].push_back(test::Json::object());
  expect_error("has 65536 materials, at most 65535 are possible");
  root_.erase("materials");
  std::vector<char> bytes;
  for (const char c : std::string(R"({"asset": {"version": "2.0"}, "nodes": [{})")) bytes.push_back(c);
  for (int i = 0; i < 2'000'000; ++i)
    for (const char c : {',', '{', '}'}) bytes.push_back(c);
  for (const char c : {']', '}'}) bytes.push_back(c);
  expect_error(write("nodes.gltf", bytes), "2 million objects");
}

}  // namespace
}  // namespace maquette
