#pragma once

#include <imgui.h>

#include <string>
#include <vector>

#include "viewer/window_input.h"

struct GLFWwindow;

namespace maquette {

struct KeyEvent {
  int key = 0;  ///< GLFW_KEY_...
  bool ctrl = false, shift = false;
};

/// Events that the callbacks collect between two frames.
struct Inbox {
  std::vector<PointerEvent> pointer;
  std::vector<KeyEvent> keys;
  std::vector<std::string> dropped;
  double last_event_s = -1e9;
  /// After the events so far: glfwGetCursorPos may already be ahead of an earlier press.
  double x = 0.0, y = 0.0;
  bool cursor_known = false;

  /// Events up to the first press or release: the panels would miss two of them in one frame. The rest follows in the
  /// next frames.
  std::vector<PointerEvent> next_pointer_events();
};

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

  /// Passes the events to ImGui. Its back end polls the present position of the mouse, which at a few frames a second
  /// is not where it was clicked.
  void begin_frame(const std::vector<PointerEvent>& events, const std::vector<KeyEvent>& keys);
  void end_frame();

 private:
  bool refresh_scale();

  GLFWwindow* window_;
  float scale_ = 0.0f, ratio_ = 0.0f;
  ImVec2 mouse_{-1.0f, -1.0f};
  bool down_[3] = {false, false, false};
  std::vector<int> tapped_;
};

}  // namespace maquette
