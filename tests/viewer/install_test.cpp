#include <gtest/gtest.h>

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
  // Shaders come from the program itself, not from a folder beside it.
  const ProgramResult render = run_in_folder(
      "/", program, {"render", "builtin:sphere", "--size", "16x16", "--samples", "4", "-o", prefix.file("a.png")});
  EXPECT_EQ(render.exit_code, 0) << render.error;
  EXPECT_GT(read_text(prefix.file("a.png")).size(), 60u);
}

}  // namespace
}  // namespace maquette
