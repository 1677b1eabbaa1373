// What the window tells the programs that drive it.
#include "viewer/window_state.h"

#include <gtest/gtest.h>

#include "scenes/files.h"
#include "tests/viewer/run_program.h"

namespace maquette {
namespace {

TEST(WindowState, IsReadAsItWasWritten) {
  const TemporaryFolder folder;
  const std::string file = folder.file("window.json");
  EXPECT_FALSE(read_window_state(file)) << "no frame yet";
  WindowState state;
  state.frames = 1234567;
  state.pictures = 12;
  state.averaged = 7;
  state.still = true;
  state.waiting = 3;
  state.work = {"visibility", "a \"file\"\nof two lines", "\xff"};
  write_window_state(file, state);
  const std::optional<WindowState> read = read_window_state(file);
  ASSERT_TRUE(read);
  state.work.back() = "\xef\xbf\xbd";  // what is no text is replaced
  EXPECT_EQ(*read, state);
}

TEST(WindowState, OtherFilesAreNone) {
  const TemporaryFolder folder;
  const std::string file = folder.file("window.json");
  for (const std::string text : {"", "{", "{}", "[]", "{\"frames\": \"many\"}"}) {
    write_file_atomically(file, std::as_bytes(std::span(text)));
    EXPECT_FALSE(read_window_state(file)) << text;
  }
}

}  // namespace
}  // namespace maquette
