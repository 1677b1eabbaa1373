#include "ui/editor.h"

#include <imgui.h>
#include <imgui_internal.h>

#include <span>

#include "ui/widgets.h"

namespace maquette {

namespace {

using panels::Ui;

constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                                    ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
                                    ImGuiWindowFlags_NoBringToFrontOnFocus;

bool begin_part(Ui& ui, const char* name, const Rect& rect, ImGuiWindowFlags flags = 0) {
  if (rect.empty()) return false;
  ImGui::SetNextWindowPos({rect.x, rect.y});
  ImGui::SetNextWindowSize({rect.width, rect.height});
  ImGui::Begin(name, nullptr, kFixed | flags);
  const ImVec2 position = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  ui.frame.windows[name] = {position.x, position.y, size.x, size.y};
  return true;
}

struct Tab {
  const char* name;
  void (*draw)(Ui& ui);
};

/// Tabs, each with its own scrolling; `open` names the one to be opened once.
void draw_tabs(Ui& ui, const char* id, std::span<const Tab> tabs, int* open) {
  if (!ImGui::BeginTabBar(id)) return;
  for (std::size_t i = 0; i < tabs.size(); ++i) {
    const bool shown =
        ImGui::BeginTabItem(tabs[i].name, nullptr, *open == static_cast<int>(i) ? ImGuiTabItemFlags_SetSelected : 0);
    panels::mark_item(ui, std::string("tab/") + tabs[i].name);
    if (!shown) continue;
    ImGui::PushStyleColor(ImGuiCol_ChildBg, ImVec4(0.0f, 0.0f, 0.0f, 0.0f));
    // Rows keep their width when a scrollbar is needed.
    bool* scrolls = ImGui::GetStateStorage()->GetBoolRef(ImGui::GetID("scrolls"), false);
    const bool visible = ImGui::BeginChild("content", {*scrolls ? 0.0f : -ImGui::GetStyle().ScrollbarSize, 0.0f});
    ImGui::PopStyleColor();
    if (visible) tabs[i].draw(ui);
    *scrolls = ImGui::GetScrollMaxY() > 0.0f;
    ImGui::EndChild();
    ImGui::EndTabItem();
  }
  *open = -1;
  ImGui::EndTabBar();
}

}  // namespace

EditorFrame draw_editor(EditorState* state, const EditorFacts& facts, EditorActions* actions) {
  EditorFrame frame;
  Ui ui{*state, facts, *actions, frame};
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  LayoutRequest request;
  request.width = size.x;
  request.height = size.y;
  request.scale = panels::scaled(100.0f) / 100.0f;
  request.left_open = state->left_open;
  request.right_open = state->right_open;
  request.picture_alone = state->presenting;
  frame.layout = compute_layout(request);
  request.strip_height = panels::strip_height(facts, frame.layout.picture.width);
  frame.layout = compute_layout(request);
  const Layout& layout = frame.layout;
  constexpr ImGuiWindowFlags kStill = ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse;

  const float padding = panels::scaled(7.0f);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {panels::scaled(10.0f), padding});
  if (begin_part(ui, "toolbar", layout.toolbar, kStill)) {
    panels::draw_toolbar(ui);
    ImGui::End();
  }
  ImGui::PopStyleVar();
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {panels::scaled(10.0f), panels::scaled(4.0f)});
  if (begin_part(ui, "status", layout.status, kStill)) {
    panels::draw_status(ui);
    ImGui::End();
  }
  if (begin_part(ui, "strip", layout.strip)) {
    panels::draw_strip(ui);
    ImGui::End();
  }
  ImGui::PopStyleVar();
  static constexpr Tab kLeft[] = {{"Materials", panels::draw_materials_panel},
                                  {"Scene", panels::draw_scene_panel},
                                  {"Help", panels::draw_help_panel},
                                  {"Review", panels::draw_review_panel}};
  static constexpr Tab kRight[] = {{"Look", panels::draw_look_panel},
                                   {"Render", panels::draw_render_panel},
                                   {"Frame", panels::draw_frame_panel},
                                   {"Error", panels::draw_error_panel},
                                   {"Inspect", panels::draw_inspection_panel}};
  state->error_view.open = false;
  state->inspection.open = false;
  panels::draw_start_popup(ui);
  if (begin_part(ui, "left", layout.left, kStill)) {
    draw_tabs(ui, "left tabs", kLeft, &state->left_tab);
    ImGui::End();
  }
  if (begin_part(ui, "right", layout.right, kStill)) {
    draw_tabs(ui, "right tabs", kRight, &state->right_tab);
    ImGui::End();
  }
  frame.editing = ImGui::IsAnyItemActive();
  // WantTextInput itself is that of the last frame, and stays for one after a field was left.
  frame.typing = frame.editing && ImGui::GetCurrentContext()->WantTextInputNextFrame == 1;
  return frame;
}

}  // namespace maquette
