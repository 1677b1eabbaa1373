// One part in several materials under several environments as one picture.
#include "viewer/render_sheet.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scenes/image_io.h"
#include "scenes/scene.h"
#include "tests/viewer/run_program.h"

namespace maquette {
namespace {

using Words = std::vector<std::string>;

TEST(JoinPictures, PutsThemInRows) {
  std::vector<Image> pictures;
  for (int i = 0; i < 3; ++i) pictures.emplace_back(2, 2, 1, static_cast<float>(i + 1));
  const Image joined = join_pictures(pictures, 2, 1);
  ASSERT_EQ(joined.width, 5);
  ASSERT_EQ(joined.height, 5);
  const std::vector<float> expected = {1, 1, 0, 2, 2, 1, 1, 0, 2, 2, 0, 0, 0, 0, 0, 3, 3, 0, 0, 0, 3, 3, 0, 0, 0};
  EXPECT_EQ(joined.data, expected);
  EXPECT_EQ(join_pictures({}, 2, 1).width, 0);
}

TEST(RenderSheet, EveryCellIsItsOwnPicture) {
  const TemporaryFolder folder;
  const std::string part = load_scene("builtin:sphere").materials.front().name;
  const Words materials = {"builtin:paint-solid-red", "builtin:paint-solid-white"},
              environments = {"builtin:clear-sky", "builtin:studio"};
  const Words common = {"builtin:sphere", "--size", "24x16", "--samples", "4", "--mode", "splitsum"};
  Words words = {"render"};
  words.insert(words.end(), common.begin(), common.end());
  for (const std::string& material : materials) words.insert(words.end(), {"--material", part + "=" + material});
  for (const std::string& environment : environments) words.insert(words.end(), {"--env", environment});
  words.insert(words.end(), {"--sheet", "-o", folder.file("sheet.exr")});
  const ProgramResult result = run_maquette(words);
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_NE(result.out.find("row 2, column 1: builtin:studio, builtin:paint-solid-red"), std::string::npos)
      << result.out;
  const Image sheet = load_hdr_image(folder.file("sheet.exr"));
  ASSERT_EQ(sheet.width, 2 * 24 + 4);
  ASSERT_EQ(sheet.height, 2 * 16 + 4);
  for (int row = 0; row < 2; ++row)
    for (int column = 0; column < 2; ++column) {
      Words single = {"render",
                      "--material",
                      part + "=" + materials[static_cast<std::size_t>(column)],
                      "--env",
                      environments[static_cast<std::size_t>(row)],
                      "-o",
                      folder.file("cell.exr")};
      single.insert(single.begin() + 1, common.begin(), common.end());
      ASSERT_EQ(run_maquette(single).exit_code, 0);
      const Image cell = load_hdr_image(folder.file("cell.exr"));
      double difference = 0.0, sum = 0.0;
      for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 24; ++x) {
          const double a = sheet.at(28 * column + x, 20 * row + y, 0), b = cell.at(x, y, 0);
          difference += std::abs(a - b);
          sum += b;
        }
      EXPECT_LT(difference, 1e-3 * sum) << "row " << row << ", column " << column;
    }
}

TEST(RenderSheet, SaysWhatIsMissing) {
  const TemporaryFolder folder;
  const auto error_of = [&](Words words) {
    words.insert(words.begin(), {"render", "builtin:sphere", "--size", "8x8", "-o", folder.file("a.png")});
    const ProgramResult result = run_maquette(words);
    EXPECT_EQ(result.exit_code, 2);
    return result.error;
  };
  EXPECT_NE(error_of({"--sheet"}).find("nothing to vary"), std::string::npos);
  EXPECT_NE(error_of({"--env", "builtin:studio", "--env", "builtin:clear-sky"}).find("add --sheet"), std::string::npos);
  EXPECT_NE(error_of({"--sheet", "--material", "A=builtin:paint-solid-red", "--material", "A=builtin:paint-solid-white",
                      "--material", "B=builtin:paint-solid-red", "--material", "B=builtin:paint-solid-white"})
                .find("varies A already"),
            std::string::npos);
  EXPECT_NE(
      error_of({"--sheet", "--time", "1", "--env", "builtin:studio", "--env", "builtin:clear-sky"}).find("settled"),
      std::string::npos);
}

}  // namespace
}  // namespace maquette
