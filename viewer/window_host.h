#pragma once

#include <imgui.h>

#include <vector>

#include "viewer/window_events.h"

struct GLFWwindow;

namespace maquette {

/// GLFW, its window and its OpenGL 4.5 context, current on this thread.
class GlfwWindow {
 public:
  /// Throws Error without a display, or below OpenGL 4.5. `inbox` outlives the window.
  GlfwWindow(int width, int height, Inbox* inbox);
  ~GlfwWindow();
  GlfwWindow(const GlfwWindow&) = delete;
  GlfwWindow& operator=(const GlfwWindow&) = delete;
  GLFWwindow* get() const { return window_; }

 private:
  GLFWwindow* window_ = nullptr;
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
  void end_frame();

 private:
  bool refresh_scale();
  void pass_pointer(const PointerEvent& event);
  void pass_key(const KeyEvent& event, bool typing);

  GLFWwindow* window_;
  float scale_ = 0.0f, ratio_ = 0.0f;
  ImVec2 mouse_{-1.0f, -1.0f};
  bool down_[3] = {false, false, false};
  bool ctrl_ = false, shift_ = false;
  std::vector<int> tapped_;
};

}  // namespace maquette
