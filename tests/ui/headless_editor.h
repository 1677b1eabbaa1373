#pragma once

#include <imgui.h>
#include <imgui_internal.h>

#include <string>

#include "ui/editor.h"

namespace maquette::test {

/// The panels without a window and without OpenGL: frames are laid out but not drawn, the mouse is set by the test.
class HeadlessEditor {
 public:
  HeadlessEditor(float width, float height, float scale = 1.0f) {
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = {width, height};
    io.DeltaTime = 1.0f / 30.0f;
    for (int key = 0; key < ImGuiKey_COUNT; ++key) io.KeyMap[key] = key;
    apply_theme(scale);
    unsigned char* pixels = nullptr;
    int w = 0, h = 0;
    io.Fonts->GetTexDataAsRGBA32(&pixels, &w, &h);
  }
  ~HeadlessEditor() { ImGui::DestroyContext(); }
  HeadlessEditor(const HeadlessEditor&) = delete;
  HeadlessEditor& operator=(const HeadlessEditor&) = delete;

  void step(int frames = 1) {
    for (int i = 0; i < frames; ++i) {
      actions = {};
      ImGui::NewFrame();
      frame = draw_editor(&state, facts, &actions);
      ImGui::Render();
    }
  }
  /// Presses and releases a button (0: left, 1: right) at the middle of an item; `actions` are those of the release.
  bool click(const std::string& item, int button = 0) {
    step(2);
    const auto found = frame.items.find(item);
    if (found == frame.items.end()) return false;
    click_at(found->second, button);
    return true;
  }
  void click_at(const Rect& r, int button = 0) {
    ImGuiIO& io = ImGui::GetIO();
    io.MousePos = {r.x + 0.5f * r.width, r.y + 0.5f * r.height};
    step();
    io.MouseDown[button] = true;
    step();
    io.MouseDown[button] = false;
    step();
    const EditorActions done = actions;
    io.MousePos = {-1.0f, -1.0f};
    step(2);
    actions = done;
  }
  /// A line of the list of names that is open.
  Rect choice(int line) {
    step(2);
    const ImGuiWindow* list = ImGui::FindWindowByName("##Combo_00");
    if (!list) return {};
    const float height = ImGui::GetTextLineHeight(), step_y = ImGui::GetTextLineHeightWithSpacing();
    return {list->Pos.x + list->WindowPadding.x,
            list->Pos.y + list->WindowPadding.y + step_y * static_cast<float>(line),
            list->Size.x - 2.0f * list->WindowPadding.x, height};
  }

  /// Drags from the middle of an item by so much.
  bool drag(const std::string& item, float dx, float dy) {
    step(2);
    const auto found = frame.items.find(item);
    if (found == frame.items.end()) return false;
    ImGuiIO& io = ImGui::GetIO();
    const Rect r = found->second;
    io.MousePos = {r.x + 0.5f * r.width, r.y + 0.5f * r.height};
    step();
    io.MouseDown[0] = true;
    step();
    for (int i = 1; i <= 4; ++i) {
      const float t = 0.25f * static_cast<float>(i);
      io.MousePos = {r.x + 0.5f * r.width + t * dx, r.y + 0.5f * r.height + t * dy};
      step();
    }
    io.MouseDown[0] = false;
    step();
    io.MousePos = {-1.0f, -1.0f};
    step(2);
    return true;
  }

  /// Presses and releases a key.
  void press(ImGuiKey key) {
    ImGui::GetIO().KeysDown[key] = true;
    step();
    ImGui::GetIO().KeysDown[key] = false;
    step(2);
  }

  EditorState state;
  EditorFacts facts;
  EditorActions actions;
  EditorFrame frame;
};

}  // namespace maquette::test
