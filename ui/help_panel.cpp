#include "ui/shortcuts.h"
#include "ui/widgets.h"

namespace maquette::panels {

void draw_help_panel(Ui& ui) {
  for (const ShortcutGroup& group : shortcut_groups()) {
    if (!section(ui, group.title.c_str())) continue;
    for (const Shortcut& shortcut : group.shortcuts) {
      ImGui::TextUnformatted(elide(shortcut.keys, scaled(112.0f)).c_str());
      tooltip(shortcut.keys);
      ImGui::SameLine(scaled(116.0f));
      ImGui::TextColored(kDim, "%s", shortcut.what.c_str());
    }
    ImGui::Spacing();
  }
}

}  // namespace maquette::panels
