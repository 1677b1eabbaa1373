// The review story in the real window: looks, saving, a kill, reopening.
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "review/open_review.h"
#include "scenes/image_io.h"
#include "tests/ui/window_fixture.h"

namespace maquette {
namespace {

class ReviewWindow : public Window {
 protected:
  void SetUp() override {
    Window::SetUp();
    folder_ = std::filesystem::temp_directory_path() / ("maquette-review-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override {
    desktop_.reset();
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  /// Whether the picture comes to look as in `wanted` rather than `other`.
  bool comes_to(const ScreenPicture& wanted, const ScreenPicture& other, const Rect& rect) {
    const double far = difference(wanted, other, rect);
    return desktop_->wait_until([&](const ScreenPicture& p) { return difference(wanted, p, rect) < 0.4 * far; },
                                kPatience_s);
  }
  std::filesystem::path folder_;
};

// Keys are lost where frames take half a second, as under a software device on a busy machine: not among those of CI yet.
TEST_F(ReviewWindow, DISABLED_LooksAreKeptChangedSavedAndSurviveAKill) {
  const Scene scene = load_scene("builtin:sphere");
  const std::string material = scene.materials.front().name;
  Controls controls(scene);
  const Rect picture = controls.picture(), middle = middle_of(picture);
  start({"builtin:sphere", "--samples", "4"});
  ASSERT_TRUE(wait_for_picture(middle)) << desktop_->errors();
  const ScreenPicture first = settled(middle);
  desktop_->input({"key", "l"});
  desktop_->click(controls.item("material/" + material));
  controls.state().selected_material = 0;
  const std::string current = scene.materials.front().measured;
  const std::string source = "builtin:" + builtin_brdfs()[current.ends_with(builtin_brdfs()[1].name) ? 2 : 1].name;
  ASSERT_TRUE(wait_for_change(first, controls.item("library/" + source), 2.0)) << "the library opens";
  desktop_->click(controls.item("library/" + source));
  ASSERT_TRUE(wait_for_change(first, middle)) << "the sphere shows the new material";
  const ScreenPicture second = settled(middle);
  desktop_->move(picture.x + 20.0f, picture.y + 20.0f);
  desktop_->input({"key", "l"});
  desktop_->input({"key", "Page_Up"});
  EXPECT_TRUE(comes_to(first, second, middle)) << "the look before";
  desktop_->input({"key", "Page_Down"});
  EXPECT_TRUE(comes_to(second, first, middle)) << "the next one";
  desktop_->input({"key", "ctrl+z"});
  EXPECT_TRUE(comes_to(first, second, middle)) << "undo takes back the change of looks";
  desktop_->input({"key", "ctrl+y"});
  EXPECT_TRUE(comes_to(second, first, middle)) << "and redo makes it again";

  const std::string file = (folder_ / "a.maquette.json").string();
  desktop_->input({"key", "ctrl+s"});
  desktop_->wait_until([&](const ScreenPicture& p) { return difference(second, p, middle) > 0.2; }, 5.0);
  desktop_->input({"type", "--delay", "80", file});
  desktop_->input({"key", "Return"});
  ASSERT_TRUE(desktop_->wait_until([&](const ScreenPicture&) { return std::filesystem::exists(file); }, kPatience_s));
  const Review saved = load_review(file);
  ASSERT_EQ(saved.looks.size(), 2u);
  EXPECT_TRUE(saved.looks[0].edits.materials.empty());
  EXPECT_EQ(saved.looks[1].edits.materials.at(material), source);
  EXPECT_EQ(saved.look.edits.materials.at(material), source);

  desktop_->input({"key", "Page_Up"});
  EXPECT_TRUE(comes_to(first, second, middle));
  const Rect left{middle.x, middle.y, 0.45f * middle.width, 0.8f * middle.height};
  const Rect right{middle.x + 0.55f * middle.width, middle.y, 0.45f * middle.width, 0.8f * middle.height};
  desktop_->input({"key", "c"});
  EXPECT_TRUE(comes_to(second, first, right)) << "B lies at the right of the wiper";
  EXPECT_TRUE(comes_to(first, second, left)) << "and A at the left";
  desktop_->input({"key", "x"});
  EXPECT_TRUE(comes_to(second, first, left)) << "swapped";
  desktop_->input({"key", "x"});
  desktop_->input({"key", "c"});
  EXPECT_TRUE(comes_to(first, second, right)) << "the comparison is over";

  desktop_->input({"key", "p"});
  const std::string written = (folder_ / "look 1.exr").string();
  ASSERT_TRUE(
      desktop_->wait_until([&](const ScreenPicture&) { return std::filesystem::exists(written); }, kPatience_s));
  const Image captured = load_hdr_image(written);
  const std::string again = (folder_ / "again.exr").string();
  const std::string command = std::string(MAQUETTE_PROGRAM) + " render '" + file + "' --look 'look 1' --average 16" +
                              " --size " + std::to_string(captured.width) + "x" + std::to_string(captured.height) +
                              " -o '" + again + "' > /dev/null";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const Image rendered = load_hdr_image(again);
  ASSERT_EQ(rendered.data.size(), captured.data.size());
  EXPECT_EQ(std::memcmp(rendered.data.data(), captured.data.data(), rendered.data.size() * sizeof(float)), 0)
      << "the window's settled picture and that of the command are the same bits";
  desktop_->kill_program();
  desktop_ = std::make_unique<Desktop>(static_cast<int>(kWidth), static_cast<int>(kHeight));
  start({file, "--samples", "4"});
  ASSERT_TRUE(wait_for_picture(middle)) << desktop_->errors();
  EXPECT_TRUE(comes_to(first, second, middle)) << "the change that was not saved";
  const auto journal = read_journal(journal_file(file));
  ASSERT_TRUE(journal);
  EXPECT_GE(journal->history.undo_count(), 4u);
  desktop_->input({"key", "ctrl+q"});
  EXPECT_EQ(desktop_->wait_for_exit(kPatience_s), 0) << desktop_->errors();
}

}  // namespace
}  // namespace maquette
