#include "viewer/window_host.h"

#include <epoxy/gl.h>
// epoxy before GLFW
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>

#include <algorithm>

#include "scenes/error.h"
#include "ui/editor.h"

namespace maquette {

std::vector<PointerEvent> Inbox::next_pointer_events() {
  const auto first_button = std::find_if(pointer.begin(), pointer.end(), [](const PointerEvent& event) {
    return event.kind == PointerEvent::Kind::press || event.kind == PointerEvent::Kind::release;
  });
  // A press comes one frame after the move to its position, because tabs must have been hovered before.
  const bool move_first = first_button != pointer.end() && first_button != pointer.begin() &&
                          first_button->kind == PointerEvent::Kind::press;
  const auto end = first_button == pointer.end() || move_first ? first_button : first_button + 1;
  const std::vector<PointerEvent> events(pointer.begin(), end);
  pointer.erase(pointer.begin(), end);
  return events;
}

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
  inbox.pointer.push_back(event);
}

/// ImGui's back end installs its own callbacks after these and calls them.
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
  glfwSetKeyCallback(window, [](GLFWwindow* w, int key, int, int action, int mods) {
    inbox_of(w).last_event_s = glfwGetTime();
    if (action != GLFW_RELEASE)
      inbox_of(w).keys.push_back({key, (mods & GLFW_MOD_CONTROL) != 0, (mods & GLFW_MOD_SHIFT) != 0});
  });
  glfwSetDropCallback(window, [](GLFWwindow* w, int count, const char** paths) {
    for (int i = 0; i < count; ++i) inbox_of(w).dropped.emplace_back(paths[i]);
  });
}

}  // namespace

GlfwWindow::GlfwWindow(int width, int height, Inbox* inbox) {
  if (!glfwInit())
    throw Error("maquette view", "there is no display (" + glfw_fault() + ")",
                "maquette render --output FILE.png draws without one");
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  window_ = glfwCreateWindow(width, height, "Maquette", nullptr, nullptr);
  if (!window_) {
    const std::string fault = glfw_fault();
    glfwTerminate();
    throw Error("graphics", "OpenGL 4.5 core is needed for a window (" + fault + ")",
                "install a newer driver or Mesa's llvmpipe (libgl1-mesa-dri); `maquette doctor` says more");
  }
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  glfwSetWindowUserPointer(window_, inbox);
  install_callbacks(window_);
}

GlfwWindow::~GlfwWindow() {
  glfwDestroyWindow(window_);
  glfwTerminate();
}

ImGuiHost::ImGuiHost(GLFWwindow* window) : window_(window) {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  refresh_scale();
  ImGui_ImplGlfw_InitForOpenGL(window, true);
  ImGui_ImplOpenGL3_Init("#version 450 core");
}

ImGuiHost::~ImGuiHost() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
}

void ImGuiHost::begin_frame(const std::vector<PointerEvent>& events, const std::vector<KeyEvent>& keys) {
  if (refresh_scale()) ImGui_ImplOpenGL3_DestroyFontsTexture();
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  ImGuiIO& io = ImGui::GetIO();
  for (const PointerEvent& event : events) {
    mouse_ = {event.x, event.y};
    if (event.button < 0 || event.button >= 3) continue;
    if (event.kind == PointerEvent::Kind::press) down_[event.button] = true;
    if (event.kind == PointerEvent::Kind::release) down_[event.button] = false;
  }
  io.MousePos = mouse_;
  for (int i = 0; i < 3; ++i) io.MouseDown[i] = down_[i];
  for (const int key : tapped_) io.KeysDown[key] = glfwGetKey(window_, key) == GLFW_PRESS;
  tapped_.clear();
  for (const KeyEvent& event : keys) {
    if (event.key < 0 || event.key >= IM_ARRAYSIZE(io.KeysDown)) continue;
    io.KeysDown[event.key] = true;  // even if it has been released since
    tapped_.push_back(event.key);
  }
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
  if (scale == scale_ && ratio == ratio_) return false;
  const bool first = scale_ == 0.0f;
  scale_ = scale;
  ratio_ = ratio;
  apply_theme(scale, ratio);
  return !first;
}

}  // namespace maquette
