#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "review/open_review.h"
#include "tests/ui/window_fixture.h"

namespace maquette {

/// A user's day in the real window. Each step waits until it has had its effect, in the review's journal, in a file or
/// in the picture, so that slow frames make it slow and nothing else. With `MAQUETTE_MANUAL_PICTURES=FOLDER` the window
/// is larger and the screens are kept there: they are the manual's.
class Story : public Window {
 protected:
  Story() : pictures_(std::getenv("MAQUETTE_MANUAL_PICTURES") ? std::getenv("MAQUETTE_MANUAL_PICTURES") : "") {
    if (!pictures_.empty()) width_ = 1280, height_ = 720;
  }
  void SetUp() override {
    const std::string missing = Desktop::missing_tools();
    if (!missing.empty()) GTEST_SKIP() << missing;
    folder_ = std::filesystem::temp_directory_path() / ("maquette-story-" + std::to_string(::getpid()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    open_desktop();
  }
  void TearDown() override {
    if (HasFailure() && desktop_) {  // what it looked like
      const std::string screen = std::string(MAQUETTE_BUILD_DIR) + "/story-failed.png";
      desktop_->save_screen(screen);
      std::fprintf(stderr, "screen: %s\n%s", screen.c_str(), desktop_->errors().c_str());
    }
    desktop_.reset();
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  void open_desktop() { desktop_ = std::make_unique<Desktop>(width_, height_); }
  void begin(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(),
                     {"view", "--size", std::to_string(width_) + "x" + std::to_string(height_), "--samples", "4"});
    desktop_->start(arguments);
  }
  Controls controls(const Scene& scene) const {
    return Controls(scene, static_cast<float>(width_), static_cast<float>(height_));
  }
  /// A click in the window, and in the panels that tell where its controls are.
  void press(Controls* at, const std::string& item) {
    desktop_->click(at->item(item));
    at->press(item);
  }
  /// Takes a line of a list of names.
  void choose(Controls* at, const std::string& list, int line) {
    press(at, list);
    desktop_->click(at->choose(line));
  }
  /// Clicks away the message below the picture, which is smaller meanwhile.
  void dismiss(Controls* at, const std::string& message) {
    const std::vector<Message> shown = {{MessageLevel::warning, message}};
    at->facts().messages = &shown;
    const Rect button = at->item("dismiss");
    at->facts().messages = nullptr;
    desktop_->click(button);
  }
  /// Replaces what stands in a text field.
  void type_into(Controls* at, const std::string& field, const std::string& text) {
    desktop_->click(at->item(field));
    desktop_->input({"key", "ctrl+a", "type", "--delay", "1", text});
  }
  void key(const std::string& name) { desktop_->input({"key", name}); }
  void drag(float x0, float y0, float x1, float y1, const std::string& button = "1") {
    std::vector<std::string> words;
    const auto move = [&](float x, float y) {
      words.insert(words.end(), {"mousemove", std::to_string(std::lround(x)), std::to_string(std::lround(y))});
    };
    move(x0, y0);
    words.insert(words.end(), {"mousedown", button});
    for (int i = 1; i <= 8; ++i)
      move(x0 + 0.125f * static_cast<float>(i) * (x1 - x0), y0 + 0.125f * static_cast<float>(i) * (y1 - y0));
    words.insert(words.end(), {"mouseup", button});
    desktop_->input(words);
  }
  /// The review as its journal has it: of `file_`, or untitled.
  std::optional<Review> review() const {
    const std::string journal = file_.empty() ? desktop_->state_folder() + "/untitled-1.journal" : journal_file(file_);
    const std::optional<JournalContents> contents = read_journal(journal);
    if (!contents) return std::nullopt;
    return review_from_document(contents->history.document(), journal);
  }
  bool wait_for(const std::function<bool()>& done) {
    return desktop_->wait_for_state([&](const WindowState&) { return done(); });
  }
  bool wait_for_review(const std::function<bool(const Review&)>& done) {
    return wait_for([&] {
      const std::optional<Review> now = review();
      return now && done(*now);
    });
  }
  bool wait_for_file(const std::filesystem::path& file) {
    return wait_for([&] { return std::filesystem::exists(file); });
  }
  /// Whether the picture comes to look as in `wanted` rather than `other`.
  bool comes_to(const ScreenPicture& wanted, const ScreenPicture& other, const Rect& rect) {
    const double far = difference(wanted, other, rect);
    return desktop_->wait_until([&](const ScreenPicture& p) { return difference(wanted, p, rect) < 0.4 * far; });
  }
  /// For the manual, once bakes and averaging change nothing any more; nothing in other runs.
  void keep_screen(const std::string& name) {
    if (pictures_.empty()) return;
    constexpr int kAveraged = 64;
    desktop_->wait_for_state([](const WindowState& s) { return s.still && s.work.empty() && s.averaged >= kAveraged; });
    desktop_->save_screen(pictures_ + "/" + name + ".png");
  }

  std::string pictures_;
  int width_ = 960, height_ = 640;
  std::filesystem::path folder_;
  std::string file_;  ///< of the review; empty: it is untitled
};

}  // namespace maquette
