#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "test_paths.h"
#include "tests/viewer/run_program.h"

namespace maquette {
namespace {

TEST(Install, ProgramRunsFromAnywhere) {
  const TemporaryFolder prefix;
  const ProgramResult install =
      run_in_folder("/", MAQUETTE_CMAKE, {"--install", MAQUETTE_BUILD_DIR, "--prefix", prefix.path().string()});
  ASSERT_EQ(install.exit_code, 0) << install.error;
  const std::string program = prefix.file("bin/maquette");
  EXPECT_EQ(run_in_folder("/", program, {"--version"}).exit_code, 0);
  // Shaders are embedded in the program, not read from a folder.
  const ProgramResult render = run_in_folder(
      "/", program, {"render", "builtin:sphere", "--size", "16x16", "--samples", "4", "-o", prefix.file("a.png")});
  EXPECT_EQ(render.exit_code, 0) << render.error;
  EXPECT_GT(read_text(prefix.file("a.png")).size(), 60u);
  // The cockpit as a file gives the same picture as the built-in one.
  for (const char* scene : {"builtin:cockpit", "cockpit.glb"}) {
    const std::string source = scene[0] == 'b' ? scene : prefix.file(std::string("share/maquette/") + scene);
    const ProgramResult picture =
        run_in_folder("/", program,
                      {"render", source, "--camera", "exterior", "--size", "96x54", "--samples", "64", "--set",
                       "shading.visibility=none", "--set", "shading.indirect=none", "--mode", "uniform", "-o",
                       prefix.file(std::string(scene + (scene[0] == 'b' ? 8 : 0)) + ".exr")});
    EXPECT_EQ(picture.exit_code, 0) << picture.error;
  }
  const ProgramResult compared =
      run_in_folder("/", program, {"compare", prefix.file("cockpit.glb.exr"), prefix.file("cockpit.exr"), "--json"});
  ASSERT_EQ(compared.exit_code, 0) << compared.error;
  EXPECT_LT(nlohmann::json::parse(compared.out)["relative_rmse"].get<double>(), 0.02);
}

}  // namespace
}  // namespace maquette
