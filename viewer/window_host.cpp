#include "viewer/window_host.h"

#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <epoxy/gl.h>

#include <algorithm>

#include "scenes/error.h"
#include "ui/editor.h"

namespace maquette {

namespace {

std::string glfw_fault() {
  const char* text = nullptr;
  glfwGetError(&text);
  return text ? text : "no reason given";
}

Inbox& inbox_of(GLFWwindow* window) { return *static_cast<Inbox*>(glfwGetWindowUserPointer(window)); }

void track_cursor(GLFWwindow* window) {
  Inbox& inbox = inbox_of(window);
  glfwGetCursorPos(window, &inbox.x, &inbox.y);
  inbox.cursor_known = true;
}

void push_pointer(GLFWwindow* window, PointerEvent event) {
  Inbox& inbox = inbox_of(window);
  if (!inbox.cursor_known) track_cursor(window);
  event.x = static_cast<float>(inbox.x);
  event.y = static_cast<float>(inbox.y);
  inbox.last_event_s = glfwGetTime();
  inbox.add(event);
}

/// The key whose letter this keyboard has there.
int key_of_layout(int key, int scancode) {
  if (key < GLFW_KEY_A || key > GLFW_KEY_Z) return key;
  const char* name = glfwGetKeyName(key, scancode);
  if (!name || name[0] == 0 || name[1] != 0) return key;
  const int letter = name[0] >= 'a' && name[0] <= 'z' ? name[0] - 'a' + GLFW_KEY_A : name[0];
  return letter >= GLFW_KEY_A && letter <= GLFW_KEY_Z ? letter : key;
}

void push_key(GLFWwindow* window, int key, int scancode, int action, int mods) {
  Inbox& inbox = inbox_of(window);
  inbox.last_event_s = glfwGetTime();
  if (action == GLFW_RELEASE && !is_modifier(key)) return;
  KeyEvent event;
  event.key = key_of_layout(key, scancode);
  event.ctrl = (mods & GLFW_MOD_CONTROL) != 0;
  event.shift = (mods & GLFW_MOD_SHIFT) != 0;
  event.released = action == GLFW_RELEASE;
  event.repeated = action == GLFW_REPEAT;
  inbox.add(event);
}

void install_callbacks(GLFWwindow* window) {
  glfwSetMouseButtonCallback(window, [](GLFWwindow* w, int button, int action, int mods) {
    PointerEvent event;
    event.shift = (mods & GLFW_MOD_SHIFT) != 0;
    event.ctrl = (mods & GLFW_MOD_CONTROL) != 0;
    event.kind = action == GLFW_PRESS ? PointerEvent::Kind::press : PointerEvent::Kind::release;
    event.button = button;
    push_pointer(w, event);
  });
  glfwSetCursorPosCallback(window, [](GLFWwindow* w, double x, double y) {
    Inbox& inbox = inbox_of(w);
    inbox.x = x;
    inbox.y = y;
    inbox.cursor_known = true;
    push_pointer(w, {});
  });
  glfwSetScrollCallback(window, [](GLFWwindow* w, double, double dy) {
    PointerEvent event;
    event.kind = PointerEvent::Kind::wheel;
    event.wheel = static_cast<float>(dy);
    push_pointer(w, event);
  });
  glfwSetKeyCallback(window, push_key);
  glfwSetCharCallback(window, [](GLFWwindow* w, unsigned letter) { inbox_of(w).add_text(letter); });
  glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** paths) {
    for (int i = 0; i < count; ++i) inbox_of(w).dropped.emplace_back(paths[i]);
  });
}

/// A window that the display's scale has made larger than its screen.
void keep_on_screen(GLFWwindow* window) {
  GLFWmonitor* monitor = glfwGetPrimaryMonitor();
  if (!monitor) return;
  int x = 0, y = 0, most_width = 0, most_height = 0, width = 0, height = 0;
  glfwGetMonitorWorkarea(monitor, &x, &y, &most_width, &most_height);
  glfwGetWindowSize(window, &width, &height);
  if (most_width < 1 || most_height < 1 || (width <= most_width && height <= most_height)) return;
  glfwSetWindowSize(window, std::min(width, most_width), std::min(height, most_height));
  glfwSetWindowPos(window, x, y);
}

}  // namespace

GlfwWindow::GlfwWindow(int width, int height, bool known, Inbox* inbox) {
  if (!glfwInit())
    throw Error("maquette view", "there is no display (" + glfw_fault() + ")",
                "maquette render --output FILE.png draws without one");
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, known ? GLFW_FALSE : GLFW_TRUE);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  window_ = glfwCreateWindow(width, height, "Maquette", nullptr, nullptr);
  if (!window_) {
    const std::string fault = glfw_fault();
    glfwTerminate();
    throw Error("graphics", "OpenGL 4.5 core is needed for a window (" + fault + ")",
                "install a newer driver or Mesa's llvmpipe (libgl1-mesa-dri); `maquette doctor` says more");
  }
  if (!known) keep_on_screen(window_);
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  glfwSetWindowUserPointer(window_, inbox);
  install_callbacks(window_);
}

bool GlfwWindow::is_full_screen() const { return glfwGetWindowMonitor(window_) != nullptr; }

void GlfwWindow::set_full_screen(bool on) {
  if (on == is_full_screen()) return;
  if (!on) return glfwSetWindowMonitor(window_, nullptr, x_, y_, width_, height_, GLFW_DONT_CARE);
  glfwGetWindowPos(window_, &x_, &y_);
  glfwGetWindowSize(window_, &width_, &height_);
  int count = 0;
  GLFWmonitor** monitors = glfwGetMonitors(&count);
  GLFWmonitor* best = nullptr;
  int most = -1;
  for (int i = 0; i < count; ++i) {
    int x = 0, y = 0;
    glfwGetMonitorPos(monitors[i], &x, &y);
    const GLFWvidmode* mode = glfwGetVideoMode(monitors[i]);
    const int common = std::max(std::min(x_ + width_, x + mode->width) - std::max(x_, x), 0) *
                       std::max(std::min(y_ + height_, y + mode->height) - std::max(y_, y), 0);
    if (common > most) {
      most = common;
      best = monitors[i];
    }
  }
  if (!best) return;
  const GLFWvidmode* mode = glfwGetVideoMode(best);
  glfwSetWindowMonitor(window_, best, 0, 0, mode->width, mode->height, mode->refreshRate);
}

GlfwWindow::~GlfwWindow() {
  glfwDestroyWindow(window_);
  glfwTerminate();
}

ImGuiHost::ImGuiHost(GLFWwindow* window) : window_(window) {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  refresh_scale();
  ImGui_ImplGlfw_InitForOpenGL(window, false);
  // Its own walk by Tab comes to text fields alone, and pages are those of looks.
  for (const int key : {ImGuiKey_Tab, ImGuiKey_PageUp, ImGuiKey_PageDown}) ImGui::GetIO().KeyMap[key] = -1;
  ImGui_ImplOpenGL3_Init("#version 450 core");
}

ImGuiHost::~ImGuiHost() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
}

void ImGuiHost::pass_pointer(const PointerEvent& event) {
  mouse_ = {event.x, event.y};
  if (event.kind == PointerEvent::Kind::wheel) ImGui::GetIO().MouseWheel += event.wheel;
  if (event.button < 0 || event.button >= 3) return;
  if (event.kind == PointerEvent::Kind::press) {
    down_[event.button] = true;
    ctrl_ = event.ctrl;
    shift_ = event.shift;
  }
  if (event.kind == PointerEvent::Kind::release) down_[event.button] = false;
}

void ImGuiHost::pass_key(const KeyEvent& event, bool typing) {
  ImGuiIO& io = ImGui::GetIO();
  if (event.key == GLFW_KEY_LEFT_CONTROL || event.key == GLFW_KEY_RIGHT_CONTROL) ctrl_ = !event.released;
  if (event.key == GLFW_KEY_LEFT_SHIFT || event.key == GLFW_KEY_RIGHT_SHIFT) shift_ = !event.released;
  if (is_modifier(event.key)) return;
  if (event.key != 0) {
    ctrl_ = event.ctrl;
    shift_ = event.shift;
  }
  const bool presses = event.key == GLFW_KEY_SPACE && !typing;  // the control that has the keyboard
  if (event.text != 0 && !event.ctrl && !presses) {
    if (typing) io.AddInputCharacter(event.text);
  } else if (event.key > 0 && event.key < IM_ARRAYSIZE(io.KeysDown)) {
    const int key = event.key == GLFW_KEY_KP_ENTER ? GLFW_KEY_ENTER : event.key;
    io.KeysDown[key] = true;  // even if it has been released since
    tapped_.push_back(key);
  }
}

void ImGuiHost::begin_frame(const InputBatch& input) {
  if (refresh_scale()) {
    ImGui_ImplOpenGL3_DestroyFontsTexture();
    ImGui_ImplOpenGL3_CreateFontsTexture();
  }
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGuiIO& io = ImGui::GetIO();
  for (const int key : tapped_) io.KeysDown[key] = false;
  tapped_.clear();
  for (const PointerEvent& event : input.pointer) pass_pointer(event);
  for (const KeyEvent& event : input.keys) pass_key(event, input.typing);
  io.MousePos = mouse_;
  for (int i = 0; i < 3; ++i) io.MouseDown[i] = down_[i];
  io.KeyCtrl = ctrl_;
  io.KeyShift = shift_;
  ImGui::NewFrame();
}

void ImGuiHost::end_frame() {
  ImGui::Render();
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

bool ImGuiHost::refresh_scale() {
  float scale = 1.0f, unused = 1.0f;
  glfwGetWindowContentScale(window_, &scale, &unused);
  int window_width = 0, width = 0, height = 0;
  glfwGetWindowSize(window_, &window_width, &height);
  glfwGetFramebufferSize(window_, &width, &height);
  const float ratio =
      window_width > 0 && width > 0 ? static_cast<float>(width) / static_cast<float>(window_width) : 1.0f;
  scale = fitting_scale(scale * text_scale_, static_cast<float>(width), static_cast<float>(height));
  if (scale == scale_ && ratio == ratio_ && glyphs_ == wanted_glyphs_) return false;
  const bool first = scale_ == 0.0f;
  scale_ = scale;
  ratio_ = ratio;
  glyphs_ = wanted_glyphs_;
  missing_glyphs_ = apply_theme(scale, ratio, glyphs_);
  return !first;
}

}  // namespace maquette
