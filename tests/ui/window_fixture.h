#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "scenes/scene.h"
#include "test_paths.h"
#include "tests/ui/desktop.h"
#include "tests/ui/headless_editor.h"
#include "viewer/session.h"

/// The real window on a separate screen, and where its controls are.
namespace maquette {

using test::Desktop;
using test::difference;
using test::HeadlessEditor;
using test::ScreenPicture;

inline constexpr float kWidth = 960.0f, kHeight = 440.0f;  // small: software draws it
inline const char* const kSize = "960x440";
inline constexpr double kSeen = 0.6;  // least mean difference of a change of the picture

/// Positions of the controls, from laying out the same panels with the same scene.
class Controls {
 public:
  explicit Controls(const Scene& scene, float width = kWidth, float height = kHeight) : editor_(width, height) {
    editor_.facts.scene = &scene;
    editor_.facts.cameras = camera_names(scene);
    editor_.facts.can_undo = true;
  }
  Rect item(const std::string& name) {
    editor_.step(3);
    return editor_.frame.items.at(name);
  }
  Rect picture() {
    editor_.step();
    return editor_.frame.layout.picture;
  }
  /// How often Tab is pressed from one control to another one of the same part.
  int steps(const std::string& from, const std::string& to) {
    const Rect begin = item(from), end = item(to);
    const auto at = [&](const Rect& rect) {
      return std::ranges::find_if(editor_.frame.stops,
                                  [&](const KeyboardStop& s) { return s.rect.x == rect.x && s.rect.y == rect.y; });
    };
    return static_cast<int>(at(end) - at(begin));
  }
  EditorState& state() { return editor_.state; }
  EditorFacts& facts() { return editor_.facts; }
  /// The same click as in the window.
  void press(const std::string& name) { editor_.click(name); }
  /// A line of the list of names that is open; chosen here, too.
  Rect choose(int line) {
    const Rect rect = editor_.choice(line);
    editor_.click_at(rect);
    return rect;
  }

 private:
  HeadlessEditor editor_;
};

inline Rect middle_of(const Rect& r) {
  return {r.x + 0.2f * r.width, r.y + 0.2f * r.height, 0.6f * r.width, 0.6f * r.height};
}

class Window : public testing::Test {
 protected:
  void SetUp() override {
    const std::string missing = Desktop::missing_tools();
    if (!missing.empty()) GTEST_SKIP() << missing;
    desktop_ = std::make_unique<Desktop>(static_cast<int>(kWidth), static_cast<int>(kHeight));
  }
  void start(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"view", "--size", kSize});
    desktop_->start(arguments);
  }
  /// Waits until something is drawn in the rectangle, and for the first coarse moments to pass.
  bool wait_for_picture(const Rect& rect) {
    return desktop_->wait_until([&](const ScreenPicture& p) { return test::contrast(p, rect) > 8.0; });
  }
  bool wait_for_change(const ScreenPicture& before, const Rect& rect, double least = kSeen) {
    return desktop_->wait_until([&](const ScreenPicture& p) { return difference(before, p, rect) > least; });
  }
  /// The screen once nothing moves, nothing is in work and some pictures are averaged.
  ScreenPicture settled() {
    constexpr int kAveraged = 12;
    desktop_->wait_for_state([](const WindowState& s) { return s.still && s.work.empty() && s.averaged >= kAveraged; });
    return desktop_->grab();
  }
  std::unique_ptr<Desktop> desktop_;
};

}  // namespace maquette
