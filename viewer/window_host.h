#pragma once

#include <imgui.h>

#include <set>
#include <vector>

#include "viewer/window_events.h"

struct GLFWwindow;

namespace maquette {

/// GLFW, its window and its OpenGL 4.5 context, current on this thread.
class GlfwWindow {
 public:
  /// Throws Error without a display, or below OpenGL 4.5. `known`: the size is one that was asked for, or that a window
  /// had; else the display's scale makes it larger, as far as the screen has room. `inbox` outlives the window.
  GlfwWindow(int width, int height, bool known, Inbox* inbox);
  ~GlfwWindow();
  GlfwWindow(const GlfwWindow&) = delete;
  GlfwWindow& operator=(const GlfwWindow&) = delete;
  GLFWwindow* get() const { return window_; }
  bool is_full_screen() const;
  /// On the monitor that has most of the window, and back.
  void set_full_screen(bool on);

 private:
  GLFWwindow* window_ = nullptr;
  int x_ = 0, y_ = 0, width_ = 0, height_ = 0;  ///< before the full screen
};

/// ImGui's context and back ends, with font and style of the display's scale.
class ImGuiHost {
 public:
  explicit ImGuiHost(GLFWwindow* window);
  ~ImGuiHost();
  ImGuiHost(const ImGuiHost&) = delete;
  ImGuiHost& operator=(const ImGuiHost&) = delete;

  /// Passes the events to ImGui. Its back end's callbacks are not used: they would run ahead of the frame that the
  /// events are for, and polled positions of the mouse are not where it was clicked.
  void begin_frame(const InputBatch& input);
  /// Of the text, beside that of the display; from the next frame on.
  void set_text_scale(float scale) { text_scale_ = scale; }
  /// Characters of names (Glyphs); from the next frame on.
  void set_glyphs(const std::set<char16_t>& glyphs) { wanted_glyphs_ = glyphs; }
  /// Those of them that no font here has.
  const std::set<char16_t>& missing_glyphs() const { return missing_glyphs_; }
  void end_frame();

 private:
  bool refresh_scale();
  void pass_pointer(const PointerEvent& event);
  void pass_key(const KeyEvent& event, bool typing);

  GLFWwindow* window_;
  float text_scale_ = 1.0f, scale_ = 0.0f, ratio_ = 0.0f;
  std::set<char16_t> glyphs_, wanted_glyphs_, missing_glyphs_;
  ImVec2 mouse_{-1.0f, -1.0f};
  bool down_[3] = {false, false, false};
  bool ctrl_ = false, shift_ = false;
  std::vector<int> tapped_;
};

}  // namespace maquette
