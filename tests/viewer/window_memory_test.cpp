// What windows remember.
#include "viewer/window_memory.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "tests/viewer/run_program.h"

namespace maquette {
namespace {

class WindowMemories : public ::testing::Test {
 protected:
  WindowMemories() { setenv("XDG_STATE_HOME", folder_.path().c_str(), 1); }
  ~WindowMemories() override { unsetenv("XDG_STATE_HOME"); }
  std::string made_file(const std::string& name) {
    std::ofstream(folder_.file(name)) << "x";
    return folder_.file(name);
  }
  TemporaryFolder folder_;
};

TEST_F(WindowMemories, ComeBack) {
  EXPECT_EQ(load_window_memory(), WindowMemory());
  WindowMemory memory;
  memory.left_open = false;
  memory.text_scale = 1.21f;
  memory.width = 1000;
  memory.height = 700;
  memory.note(made_file("a.glb"));
  memory.note(made_file("b.glb"));
  memory.note("builtin:cockpit");
  memory.note(folder_.file("a.glb"));
  EXPECT_EQ(memory.recent, (std::vector<std::string>{folder_.file("a.glb"), folder_.file("b.glb")}));
  save_window_memory(memory);
  EXPECT_EQ(load_window_memory(), memory);
  std::filesystem::remove(folder_.file("a.glb"));
  EXPECT_EQ(load_window_memory().recent, (std::vector<std::string>{folder_.file("b.glb")}))
      << "what is gone is not offered";
  for (int i = 0; i < 40; ++i) memory.note("/x/" + std::to_string(i));
  EXPECT_EQ(memory.recent.size(), WindowMemory::kMostRecent);
  EXPECT_EQ(memory.recent.front(), "/x/39");
}

TEST_F(WindowMemories, DamagedOnesAreAsNew) {
  save_window_memory({});
  const std::string file = folder_.file("maquette/window.json"), whole = read_text(file);
  for (const std::string& text : {whole.substr(0, whole.size() / 2), std::string("[]"), std::string(),
                                  std::string(R"({"recent": [], "left_open": true, "right_open": 3})")}) {
    std::ofstream(file) << text;
    EXPECT_EQ(load_window_memory(), WindowMemory()) << text;
  }
}

}  // namespace
}  // namespace maquette
