#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "scenes/image_io.h"
#include "tests/viewer/run_program.h"

namespace maquette {
namespace {

using Json = nlohmann::json;

Image ramp(int width, int height, float add = 0.0f) {
  Image image(width, height, 4, 1.0f);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = 0.1f * static_cast<float>(x + y) + (x > 10 ? add : 0.0f);
  return image;
}

TEST(Compare, PrintsAllFiguresAndWritesTheDifference) {
  const TemporaryFolder folder;
  save_exr(folder.file("a.exr"), ramp(24, 16, 0.5f));
  save_exr(folder.file("b.exr"), ramp(24, 16));
  const ProgramResult text = run_maquette({"compare", folder.file("a.exr"), folder.file("b.exr")});
  ASSERT_EQ(text.exit_code, 0) << text.error;
  const ProgramResult json =
      run_maquette({"compare", folder.file("a.exr"), folder.file("b.exr"), "--json", "-o", folder.file("d.png")});
  ASSERT_EQ(json.exit_code, 0) << json.error;
  const Json figures = Json::parse(json.out);
  for (const char* key : {"rmse", "relative_rmse", "psnr", "relmse", "flip", "flip_ldr", "ssim"}) {
    EXPECT_TRUE(figures[key].is_number()) << key;
    std::string printed = key;
    std::replace(printed.begin(), printed.end(), '_', ' ');
    EXPECT_NE(text.out.find(printed), std::string::npos) << printed;
  }
  EXPECT_GT(figures["flip"].get<double>(), 0.01);
  EXPECT_LT(figures["ssim"].get<double>(), 1.0);
  EXPECT_EQ(read_text(folder.file("d.png")).substr(1, 3), "PNG");
  ASSERT_EQ(run_maquette({"compare", folder.file("a.exr"), folder.file("b.exr"), "-o", folder.file("d.exr")}).exit_code,
            0);
  const Image difference = load_hdr_image(folder.file("d.exr"));
  EXPECT_NEAR(difference.at(20, 5, 1), 0.5f, 1e-5f);
  EXPECT_EQ(difference.at(5, 5, 1), 0.0f);
}

TEST(Compare, TellsOfHeaderLinesThatItCannotFollow) {
  const TemporaryFolder folder;
  const std::string texel("\x80\x40\x20\x81", 4);
  std::ofstream(folder.file("odd.hdr"), std::ios::binary) << "#?RADIANCE\nGAMMA=2.2\n\n-Y 1 +X 1\n" << texel;
  std::ofstream(folder.file("plain.hdr"), std::ios::binary) << "#?RADIANCE\n\n-Y 1 +X 1\n" << texel;
  const ProgramResult result = run_maquette({"compare", folder.file("plain.hdr"), folder.file("odd.hdr")});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.error,
            "warning: " + folder.file("odd.hdr") + ": the line GAMMA=2.2 is ignored: Radiance pictures are linear\n");
}

TEST(Compare, AnswersForBadPictures) {
  const TemporaryFolder folder;
  save_exr(folder.file("a.exr"), ramp(24, 16));
  save_exr(folder.file("other.exr"), ramp(16, 16));
  save_exr(folder.file("black.exr"), Image(24, 16, 3));
  Image broken = ramp(24, 16);
  broken.at(3, 3, 0) = std::numeric_limits<float>::quiet_NaN();
  save_exr(folder.file("broken.exr"), broken);
  const auto answer = [&](const char* image, const char* reference) {
    return run_maquette({"compare", folder.file(image), folder.file(reference)});
  };
  const ProgramResult size = answer("a.exr", "other.exr");
  EXPECT_EQ(size.exit_code, 1);
  EXPECT_NE(size.error.find("24x16"), std::string::npos) << size.error;
  const ProgramResult black = answer("a.exr", "black.exr");
  EXPECT_EQ(black.exit_code, 0);
  EXPECT_NE(black.out.find("the reference is black"), std::string::npos) << black.out;
  const ProgramResult nan = answer("broken.exr", "a.exr");
  EXPECT_EQ(nan.exit_code, 0);
  EXPECT_NE(nan.out.find("1 pixels are NaN"), std::string::npos) << nan.out;
  const ProgramResult folderless =
      run_maquette({"compare", folder.file("a.exr"), folder.file("a.exr"), "-o", folder.file("no/d.png")});
  EXPECT_EQ(folderless.exit_code, 1);
  EXPECT_EQ(run_maquette({"compare", folder.file("a.exr"), folder.file("a.exr"), "-o", "d.jpg"}).exit_code, 2);
  // The difference may not replace what it is the difference of, by whatever name.
  const std::string before = read_text(folder.file("a.exr"));
  const ProgramResult replacing =
      run_maquette({"compare", folder.file("black.exr"), folder.file("a.exr"), "-o", folder.file("./a.exr")});
  EXPECT_EQ(replacing.exit_code, 2);
  EXPECT_NE(replacing.error.find("would replace"), std::string::npos) << replacing.error;
  EXPECT_EQ(read_text(folder.file("a.exr")), before);
}

}  // namespace
}  // namespace maquette
