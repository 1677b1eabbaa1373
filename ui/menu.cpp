// The menu: every command of the window, with its keys.
#include "ui/shortcuts.h"
#include "ui/widgets.h"

namespace maquette::panels {

namespace {

void draw_cameras(Ui& ui, const Shortcut& shortcut) {
  if (!ImGui::BeginMenu(shortcut.what.c_str(), !ui.facts.cameras.empty())) return;
  for (std::size_t i = 0; i < ui.facts.cameras.size(); ++i)
    if (ImGui::MenuItem(ui.facts.cameras[i].c_str(), i < 9 ? std::to_string(i + 1).c_str() : nullptr))
      ui.actions.go_to_camera = static_cast<int>(i);
  ImGui::EndMenu();
}

void draw_panel_names(Ui& ui) {
  if (!ImGui::BeginMenu("panels")) return;
  for (int i = 0; i < static_cast<int>(std::size(kPanelNames)); ++i) {
    if (ImGui::MenuItem(kPanelNames[i], ("Ctrl+" + std::to_string(i + 1)).c_str())) open_panel(&ui.state, i);
    mark_item(ui, std::string("menu/") + kPanelNames[i]);
  }
  ImGui::EndMenu();
}

void draw_group(Ui& ui, const ShortcutGroup& group) {
  for (const Shortcut& shortcut : group.shortcuts) {
    if (shortcut.command == Command::none || shortcut.command == Command::menu) continue;
    if (shortcut.command == Command::camera) {
      draw_cameras(ui, shortcut);
    } else if (shortcut.command == Command::panel) {
      draw_panel_names(ui);
    } else {
      if (ImGui::MenuItem(shortcut.what.c_str(), shortcut.keys.c_str()))
        ui.actions.commands.push_back(shortcut.command);
      mark_item(ui, "menu/" + shortcut.what);
    }
  }
}

}  // namespace

void draw_menu(Ui& ui) {
  if (ImGui::Button("Menu")) ui.state.menu_popup = true;
  mark_item(ui, "menu");
  take_keyboard(ui, "toolbar");
  tooltip("All commands with their keys (F10)");
  if (ui.state.menu_popup) ImGui::OpenPopup("menu");
  ui.state.menu_popup = false;
  const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
  ImGui::SetNextWindowPos({low.x, high.y + scaled(3.0f)}, ImGuiCond_Appearing);
  if (!ImGui::BeginPopup("menu")) return;
  for (const ShortcutGroup& group : shortcut_groups()) {
    const bool shown = ImGui::BeginMenu(group.title.c_str());
    mark_item(ui, "menu/" + group.title);
    if (!shown) continue;
    draw_group(ui, group);
    ImGui::EndMenu();
  }
  ImGui::EndPopup();
}

}  // namespace maquette::panels

namespace maquette {

void open_panel(EditorState* state, int panel) {
  const bool left = panel < kLeftPanels;
  (left ? state->left_open : state->right_open) = true;
  (left ? state->left_tab : state->right_tab) = left ? panel : panel - kLeftPanels;
  state->right_first = !left;
  state->keyboard_goes_to = left ? "left" : "right";
}

}  // namespace maquette
