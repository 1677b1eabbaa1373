// Shading mode, its settings as declared, resolution and debug views.
#include <algorithm>
#include <cmath>

#include "render/technique/registry.h"
#include "ui/widgets.h"

namespace maquette::panels {

namespace {

const char* const kScaleNames[] = {"25 %", "50 %", "100 %", "automatic"};
constexpr float kScales[] = {0.25f, 0.5f, 1.0f, 0.0f};

void scale_combo(const char* id, float* scale, int count) {
  int index = 2;
  for (int i = 0; i < count; ++i)
    if (*scale == kScales[i]) index = i;
  if (ImGui::Combo(id, &index, kScaleNames, count)) *scale = kScales[index];
}

void draw_mode(Ui& ui) {
  row_label("Mode");
  if (ImGui::BeginCombo("##mode", ui.state.mode.c_str())) {
    for (const Technique& technique : ui.facts.registry->techniques) {
      if (technique.kind != TechniqueKind::mode) continue;
      if (ImGui::Selectable(technique.name.c_str(), technique.name == ui.state.mode)) ui.state.mode = technique.name;
      mark_item(ui, "mode/" + technique.name);
      tooltip(technique.help);
    }
    ImGui::EndCombo();
  } else {
    mark_item(ui, "mode");
  }
  for (const Technique& technique : ui.facts.registry->techniques)
    if (technique.name == ui.state.mode) dim_text(technique.help);
}

void draw_reflections(Ui& ui) {
  row_label("Reflections");
  if (!ImGui::BeginCombo("##reflections", ui.state.reflections.c_str())) {
    mark_item(ui, "reflections");
    return;
  }
  const auto choice = [&](const std::string& name, const std::string& help) {
    if (ImGui::Selectable(name.c_str(), name == ui.state.reflections)) ui.state.reflections = name;
    mark_item(ui, "reflections/" + name);
    tooltip(help);
  };
  choice(kAutoReflections, "the exact technique, where the picture shows a mirror or glass");
  choice(kNoReflections, "mirrors and glass show the sky only");
  for (const Technique& technique : ui.facts.registry->techniques)
    if (technique.kind == TechniqueKind::reflector) choice(technique.name, technique.help);
  ImGui::EndCombo();
}

/// Selection of the parts that reflect: by clicks in the picture; the scene tree shows them.
void draw_reflector_picking(Ui& ui) {
  EditorState& state = ui.state;
  if (state.reflections == kNoReflections) {
    if (state.tool == Tool::reflect) state.tool = Tool::camera;
    return;
  }
  row_label("Reflectors");
  if (toggle_button("Pick", state.tool == Tool::reflect))
    state.tool = state.tool == Tool::reflect ? Tool::camera : Tool::reflect;
  mark_item(ui, "pick reflectors");
  tooltip("Click on a pane or a mirror in the picture: it becomes a reflector, or is one no more (Esc leaves)");
  ImGui::SameLine();
  ImGui::BeginDisabled(state.edits.reflectors.empty());
  if (ImGui::Button("As in the scene")) state.edits.reflectors.clear();
  mark_item(ui, "scene reflectors");
  ImGui::EndDisabled();
  tooltip("Those that the scene marks, or all its panes where it marks none");
  dim_text(std::to_string(ui.facts.reflecting.size()) + " reflect; the scene tree names them");
}

/// Whether a technique's settings change this picture.
bool has_effect(const Ui& ui, const Technique& technique) {
  const Registry& registry = *ui.facts.registry;
  const Technique& mode = registry.find_mode(ui.state.mode);
  const Technique* reflector = registry.find_reflector(ui.state.reflections);
  if (technique.has_effect) return technique.has_effect(mode, reflector, ui.state.settings);
  if (technique.kind == TechniqueKind::mode) return &technique == &mode;
  return technique.kind == TechniqueKind::shared || &technique == reflector;
}

void draw_settings(Ui& ui) {
  bool any = false;
  for (const Technique& technique : ui.facts.registry->techniques) {
    if (!has_effect(ui, technique) || technique.settings.empty()) continue;
    dim_text(technique.name);
    for (const SettingDeclaration& declaration : technique.settings) {
      setting_row(ui, declaration);
      any = true;
    }
  }
  if (!any) dim_text("This mode has no settings.");
  if (ui.state.settings.changed().empty()) return;
  if (ImGui::Button("Reset all")) ui.state.settings = Settings();
  mark_item(ui, "reset all");
}

void draw_resolution(Ui& ui) {
  row_label("Still", "Picture pixels a window pixel when nothing moves");
  scale_combo("##still", &ui.state.still_scale, 3);
  mark_item(ui, "still scale");
  row_label("Moving", "And while the camera, the light or a surface moves");
  scale_combo("##moving", &ui.state.moving_scale, 4);
  mark_item(ui, "moving scale");
  row_label("Antialiasing",
            "Samples a pixel; shading is shared where it varies little. At rest: once nothing has moved for a while");
  struct Choice {
    int msaa, still_msaa;
  };
  constexpr Choice kChoices[] = {{1, 1}, {1, 4}, {4, 4}, {16, 16}};
  static const char* const kNames[] = {"off", "4 samples at rest", "4 samples", "16 samples"};
  int index = ui.state.msaa >= 16 ? 3 : ui.state.msaa >= 4 ? 2 : ui.state.still_msaa > 1 ? 1 : 0;
  if (ImGui::Combo("##msaa", &index, kNames, 4)) {
    ui.state.msaa = kChoices[index].msaa;
    ui.state.still_msaa = kChoices[index].still_msaa;
  }
  mark_item(ui, "msaa");
}

void draw_debug_views(Ui& ui) {
  row_label("View", "An intermediate of the frame instead of the picture");
  const std::string shown = ui.state.debug_view.empty() ? "picture" : ui.state.debug_view;
  if (ImGui::BeginCombo("##view", shown.c_str(), ImGuiComboFlags_HeightLarge)) {
    if (ImGui::Selectable("picture", ui.state.debug_view.empty())) ui.state.debug_view.clear();
    for (const std::string& name : Renderer::debug_view_names())
      if (ImGui::Selectable(name.c_str(), name == ui.state.debug_view)) ui.state.debug_view = name;
    ImGui::EndCombo();
  }
  mark_item(ui, "view");
  if (ui.state.debug_view.empty()) return;
  if (ImGui::Button("Back to the picture")) ui.state.debug_view.clear();
  mark_item(ui, "view/picture");
}

/// The settled picture as a file, of any size.
void draw_picture_file(Ui& ui) {
  PictureFile& file = ui.state.picture_file;
  row_label("Size", "Of the file, in pixels");
  const float gap = ImGui::GetStyle().ItemInnerSpacing.x, width = 0.5f * (ImGui::GetContentRegionAvail().x - gap);
  for (int* side : {&file.width, &file.height}) {
    const bool first = side == &file.width;
    if (!first) ImGui::SameLine(0.0f, gap);
    ImGui::SetNextItemWidth(width);
    ImGui::InputInt(first ? "##file width" : "##file height", side, 0);
    mark_item(ui, first ? "file/width" : "file/height");
    *side = std::clamp(*side, 1, 16384);
  }
  row_label("Antialiasing", "Samples a pixel");
  static const char* const kNames[] = {"off", "4 samples", "16 samples"};
  int index = file.msaa >= 16 ? 2 : file.msaa >= 4 ? 1 : 0;
  if (ImGui::Combo("##file msaa", &index, kNames, 3)) file.msaa = index == 2 ? 16 : index == 1 ? 4 : 1;
  mark_item(ui, "file/msaa");
  row_label("Averaged", "Frames, which it takes so many times the time of one; in mode reference paths a pixel");
  auto frames = static_cast<float>(file.frames);
  if (slider("##file frames", &frames, 1.0f, 1024.0f, "%.0f", ImGuiSliderFlags_Logarithmic))
    file.frames = std::max(static_cast<int>(std::lround(frames)), 1);
  mark_item(ui, "file/frames");
  ImGui::Checkbox("PNG", &file.png);
  mark_item(ui, "file/png");
  tooltip("Tone mapped, instead of linear EXR");
  ImGui::SameLine();
  if (!ui.facts.picture_in_work.empty()) {
    if (ImGui::Button("Cancel the picture")) ui.actions.cancel_picture = true;
    mark_item(ui, "file/cancel");
    tooltip(ui.facts.picture_in_work + " is being drawn");
    return;
  }
  if (ImGui::Button("Save the picture")) ui.actions.save_picture = true;
  mark_item(ui, "file/save");
  tooltip("Beside the review, drawn by a program of its own while you work on");
}

}  // namespace

void draw_render_panel(Ui& ui) {
  if (section(ui, "Shading mode")) {
    draw_mode(ui);
    draw_reflections(ui);
    draw_reflector_picking(ui);
  }
  if (section(ui, "Settings")) draw_settings(ui);
  if (section(ui, "Resolution")) draw_resolution(ui);
  if (section(ui, "Picture as a file")) draw_picture_file(ui);
  if (section(ui, "Debug view")) draw_debug_views(ui);
}

}  // namespace maquette::panels
