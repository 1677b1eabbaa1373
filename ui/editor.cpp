#include "ui/editor.h"

#include <imgui.h>
#include <imgui_internal.h>

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "ui/widgets.h"

namespace maquette {

namespace {

using panels::Ui;

constexpr ImGuiWindowFlags kFixed = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                                    ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings |
                                    ImGuiWindowFlags_NoBringToFrontOnFocus |
                                    ImGuiWindowFlags_NoFocusOnAppearing;  // which would close dialogs

bool begin_part(Ui& ui, const char* name, const Rect& rect, ImGuiWindowFlags flags = 0) {
  if (rect.empty()) return false;
  ImGui::SetNextWindowPos({rect.x, rect.y});
  ImGui::SetNextWindowSize({rect.width, rect.height});
  ImGui::Begin(name, nullptr, kFixed | flags);
  const ImVec2 position = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  ui.frame.windows[name] = {position.x, position.y, size.x, size.y};
  return true;
}

using DrawPanel = void (*)(Ui& ui);

/// Tabs, each with its own scrolling; `open` names the one to be opened once.
void draw_tabs(Ui& ui, const std::string& part, const char* const* names, std::span<const DrawPanel> draw, int* open) {
  if (!ImGui::BeginTabBar((part + " tabs").c_str())) return;
  for (std::size_t i = 0; i < draw.size(); ++i) {
    const bool opens = *open == static_cast<int>(i);
    const bool shown = ImGui::BeginTabItem(names[i], nullptr, opens ? ImGuiTabItemFlags_SetSelected : 0);
    panels::mark_item(ui, std::string("tab/") + names[i]);
    if (!shown) continue;
    if (*open < 0 || opens) panels::take_keyboard(ui, part.c_str());
    ImGui::PushStyleColor(ImGuiCol_ChildBg, ImVec4(0.0f, 0.0f, 0.0f, 0.0f));
    // Rows keep their width when a scrollbar is needed.
    bool* scrolls = ImGui::GetStateStorage()->GetBoolRef(ImGui::GetID("scrolls"), false);
    const bool visible = panels::begin_list("content", 0.0f, *scrolls ? 0.0f : -ImGui::GetStyle().ScrollbarSize);
    ImGui::PopStyleColor();
    if (visible) draw[i](ui);
    *scrolls = ImGui::GetScrollMaxY() > 0.0f;
    ImGui::EndChild();
    ImGui::EndTabItem();
  }
  *open = -1;
  ImGui::EndTabBar();
}

/// To the next control of the same part, and from the last one to the first.
void step_keyboard(Ui& ui) {
  const int step = std::exchange(ui.state.keyboard_step, 0);
  const ImGuiContext& context = *ImGui::GetCurrentContext();
  if (step == 0 || !context.NavWindow) return;
  std::vector<KeyboardStop> stops = ui.frame.stops;
  std::erase_if(stops, [&](const KeyboardStop& s) { return s.part != context.NavWindow->RootWindow->Name; });
  if (stops.empty()) return;
  const int count = static_cast<int>(stops.size());
  const auto at = std::ranges::find(stops, context.NavId, &KeyboardStop::item);
  const int from = at == stops.end() ? (step > 0 ? -1 : 0) : static_cast<int>(at - stops.begin());
  panels::give_keyboard(stops[static_cast<std::size_t>((from + step + count) % count)]);
}

/// Where the keyboard is, once it has been given away.
void find_keyboard(Ui& ui) {
  if (ui.state.keyboard_goes_to == "picture") ImGui::FocusWindow(nullptr);
  // A tab that is being opened takes it in the next frame.
  if (!ui.frame.windows.contains(ui.state.keyboard_goes_to)) ui.state.keyboard_goes_to.clear();
  ui.frame.navigating = ImGui::GetIO().NavVisible;
  const auto at = std::ranges::find(ui.frame.stops, ImGui::GetCurrentContext()->NavId, &KeyboardStop::item);
  ui.state.keyboard_types = at != ui.frame.stops.end() && at->typed;
  const ImGuiWindow* window = ImGui::GetCurrentContext()->NavWindow;
  if (!ui.frame.navigating || !window) return;
  const std::string name = window->RootWindow->Name;
  if (ui.frame.windows.contains(name)) ui.frame.keyboard_part = name;
}

}  // namespace

EditorFrame draw_editor(EditorState* state, const EditorFacts& facts, EditorActions* actions) {
  EditorFrame frame;
  Ui ui{*state, facts, *actions, frame};
  panels::press_by_enter(state->keyboard_types);
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  LayoutRequest request;
  request.width = size.x;
  request.height = size.y;
  request.scale = panels::scaled(100.0f) / 100.0f;
  request.left_open = state->left_open;
  request.right_open = state->right_open;
  request.picture_alone = state->presenting;
  request.right_first = state->right_first;
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
  static constexpr DrawPanel kPanels[] = {
      panels::draw_materials_panel, panels::draw_scene_panel, panels::draw_help_panel,
      panels::draw_review_panel,    panels::draw_look_panel,  panels::draw_render_panel,
      panels::draw_frame_panel,     panels::draw_error_panel, panels::draw_inspection_panel};
  static_assert(std::size(kPanels) == std::size(kPanelNames));
  const std::span<const DrawPanel> all(kPanels);
  state->error_view.open = false;
  state->inspection.open = false;
  panels::draw_start_popup(ui);
  if (begin_part(ui, "left", layout.left, kStill)) {
    draw_tabs(ui, "left", kPanelNames, all.first(kLeftPanels), &state->left_tab);
    ImGui::End();
  }
  if (begin_part(ui, "right", layout.right, kStill)) {
    draw_tabs(ui, "right", kPanelNames + kLeftPanels, all.subspan(kLeftPanels), &state->right_tab);
    ImGui::End();
  }
  actions->drop_source = panels::dropped_source(ui);
  step_keyboard(ui);
  find_keyboard(ui);
  frame.editing = ImGui::IsAnyItemActive();
  // WantTextInput itself is that of the last frame, and stays for one after a field was left.
  frame.typing = frame.editing && ImGui::GetCurrentContext()->WantTextInputNextFrame == 1;
  return frame;
}

}  // namespace maquette
