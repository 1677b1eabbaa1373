// What a window offers before anything is open: recent files, built-in scenes, a path.
#include <algorithm>
#include <filesystem>

#include "ui/widgets.h"

namespace maquette::panels {

namespace {

struct BuiltIn {
  const char *source, *what;
};
constexpr BuiltIn kBuiltIns[] = {{"builtin:cockpit", "a car interior"},
                                 {"builtin:seat", "a seat beside a mirror wall"},
                                 {"builtin:open-seat", "a seat under the sky"},
                                 {"builtin:plate", "four statues on marble"},
                                 {"builtin:sphere", "a sphere"},
                                 {"builtin:cornell", "a coloured box"}};

void line(Ui& ui, const std::string& source, const std::string& name, const std::string& behind) {
  ImGui::PushID(source.c_str());
  const float whole = std::min(scaled(430.0f), ImGui::GetIO().DisplaySize.x - scaled(60.0f));
  const float column = 0.44f * whole;
  if (ImGui::Selectable("##file", false, 0, {whole, 0.0f})) {
    ui.actions.open_path = source;
    ImGui::CloseCurrentPopup();
  }
  mark_item(ui, "start/" + source);
  ImGui::SameLine(ImGui::GetStyle().WindowPadding.x);
  ImGui::TextUnformatted(elide(name, column - scaled(10.0f)).c_str());
  ImGui::SameLine(column);
  ImGui::TextColored(kDim, "%s", elide(behind, whole - column).c_str());
  ImGui::PopID();
}

}  // namespace

void draw_start_popup(Ui& ui) {
  if (ui.state.start_popup) ImGui::OpenPopup("start");
  ui.state.start_popup = false;
  const ImVec2 window = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * window.x, 0.45f * window.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSizeConstraints({0.0f, 0.0f}, {window.x, std::max(window.y - scaled(90.0f), 1.0f)});
  if (!ImGui::BeginPopup("start")) return;
  const ImVec2 at = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  ui.frame.items["start"] = {at.x, at.y, size.x, size.y};
  if (!ui.facts.recent_files.empty()) {
    dim_text("Recent");
    for (const std::string& file : ui.facts.recent_files) {
      const std::filesystem::path path(file);
      line(ui, file, path.filename().string(), path.parent_path().string());
    }
    ImGui::Spacing();
  }
  dim_text("Built in");
  for (const BuiltIn& scene : kBuiltIns) line(ui, scene.source, std::string(scene.source).substr(8), scene.what);
  ImGui::Spacing();
  if (ImGui::Button("Another file...")) {
    ui.state.open_path_popup = true;
    ImGui::CloseCurrentPopup();
  }
  mark_item(ui, "start/another");
  ImGui::SameLine();
  dim_text("or drop one on the window. F1 lists the keys.");
  ImGui::EndPopup();
}

}  // namespace maquette::panels
