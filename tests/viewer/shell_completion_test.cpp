// What shells complete, and the page for man: made from the declarations.
#include "viewer/shell_completion.h"

#include <gtest/gtest.h>

#include "scenes/error.h"
#include "tests/support/text.h"
#include "tests/viewer/run_program.h"
#include "viewer/command_line.h"
#include "viewer/outputs.h"

namespace maquette {
namespace {

using test::contains;

TEST(ShellCompletion, HoldsEveryCommandAndOption) {
  for (const std::string& text : {shell_completion("bash"), shell_completion("zsh"), manual_roff()}) {
    for (const CommandDeclaration& command : command_declarations()) EXPECT_TRUE(contains(text, command.name));
    for (const OptionDeclaration& option : option_declarations()) {
      std::string dashes;  // as roff has them
      for (const char c : option.name) dashes += c == '-' ? std::string("\\-") : std::string(1, c);
      EXPECT_TRUE(contains(text, option.name) || contains(text, dashes)) << option.name;
    }
  }
  EXPECT_THROW(shell_completion("fish"), UsageError);
}

/// What bash offers after `words`, of which the last is being typed.
std::string offered(const TemporaryFolder& folder, const std::string& words) {
  const std::string script = "source '" + folder.file("maquette.bash") + "'; COMP_WORDS=(maquette " + words +
                             "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _maquette; echo \"${COMPREPLY[*]}\"";
  const ProgramResult result = run_in_folder("/", "/bin/bash", {"-c", script});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(result.error, "");
  return result.out;
}

TEST(ShellCompletion, BashCompletes) {
  const TemporaryFolder folder;
  write_text(folder.file("maquette.bash"), shell_completion("bash"));
  EXPECT_EQ(offered(folder, "ren"), "render\n");
  EXPECT_EQ(offered(folder, "render --mode uni"), "uniform\n");
  EXPECT_EQ(offered(folder, "render --reflections off"), "off\n");
  EXPECT_EQ(offered(folder, "compare --js"), "--json\n");
  EXPECT_EQ(offered(folder, "compare --mod"), "\n");
  EXPECT_EQ(offered(folder, "render --set octree.dep"), "octree.depth=\n");
  EXPECT_EQ(offered(folder, "view '" + folder.file("maq") + "'"), folder.file("maquette.bash") + "\n");
}

TEST(ShellCompletion, ZshReadsIt) {
  if (run_in_folder("/", "/bin/sh", {"-c", "command -v zsh"}).exit_code != 0) GTEST_SKIP() << "zsh is not installed";
  const TemporaryFolder folder;
  write_text(folder.file("_maquette"), shell_completion("zsh"));
  const ProgramResult result = run_in_folder("/", "/bin/sh", {"-c", "zsh -n '" + folder.file("_maquette") + "'"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(result.error, "");
}

}  // namespace
}  // namespace maquette
