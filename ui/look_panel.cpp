// Cameras, variants, light, exposure and tone mapping.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "scenes/environment.h"
#include "ui/camera_control.h"
#include "ui/widgets.h"

namespace maquette::panels {

namespace {

std::string environment_label(const std::string& source) {
  if (source.starts_with("builtin:")) return source.substr(8);
  return std::filesystem::path(source).filename().string();
}

void draw_cameras(Ui& ui) {
  const float spacing = ImGui::GetStyle().ItemInnerSpacing.x;
  const float width = (ImGui::GetContentRegionAvail().x - spacing) / 2.0f;
  for (std::size_t i = 0; i < ui.facts.cameras.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    const std::string label = (i < 9 ? std::to_string(i + 1) + "  " : "") + ui.facts.cameras[i];
    if (i % 2 == 1) ImGui::SameLine(0.0f, spacing);
    if (ImGui::Button(elide(label, width - scaled(12.0f)).c_str(), {width, 0.0f}))
      ui.actions.go_to_camera = static_cast<int>(i);
    mark_item(ui, "camera/" + ui.facts.cameras[i]);
    tooltip(ui.facts.cameras[i]);
    ImGui::PopID();
  }
  if (ImGui::Button("Copy as command")) ImGui::SetClipboardText(ui.facts.command.c_str());
  mark_item(ui, "copy as command");
  tooltip(ui.facts.command);
  CameraView& camera = ui.state.camera;
  CameraView view = camera;
  row_label("Eye, m", "Where the camera is, in the scene");
  number_fields(ui, "camera/eye", &view.eye.x, 3, "%.3f");
  row_label("Target, m", "What it looks at");
  number_fields(ui, "camera/target", &view.target.x, 3, "%.3f");
  if (glm::distance(view.eye, view.target) > 1e-6f * (1.0f + glm::length(view.eye))) camera = view;
  bool orthographic = camera.is_orthographic();
  row_label("Orthographic", "Parallel rays: equal lengths look equal at every distance");
  if (ImGui::Checkbox("##orthographic", &orthographic)) set_orthographic(&camera, orthographic);
  mark_item(ui, "camera/orthographic");
  if (orthographic) {
    row_label("Height", "Of what the picture shows");
    ImGui::DragFloat("##height", &camera.height_m, 0.01f * camera.height_m, 1e-6f, 1e9f, "%.4g m",
                     ImGuiSliderFlags_AlwaysClamp);
    mark_item(ui, "camera/height");
    return;
  }
  float fov_deg = glm::degrees(camera.fov_y_rad);
  row_label("Field of view", "Vertical angle of view");
  if (slider("##fov", &fov_deg, 5.0f, 120.0f, "%.0f\u00b0", ImGuiSliderFlags_AlwaysClamp))
    camera.fov_y_rad = glm::radians(fov_deg);
  mark_item(ui, "camera/fov");
}

void draw_variants(Ui& ui) {
  const std::vector<std::string>& variants = ui.facts.scene->variants;
  if (ImGui::RadioButton("As in the file", ui.state.edits.variant.empty())) ui.state.edits.variant.clear();
  mark_item(ui, "variant/");
  for (std::size_t i = 0; i < variants.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    if (ImGui::RadioButton(variants[i].c_str(), ui.state.edits.variant == variants[i]))
      ui.state.edits.variant = variants[i];
    mark_item(ui, "variant/" + variants[i]);
    ImGui::PopID();
  }
}

void environment_row(Ui& ui, const std::string& source) {
  const bool selected = source == ui.state.edits.environment;
  if (ImGui::Selectable(environment_label(source).c_str(), selected)) ui.state.edits.environment = source;
  mark_item(ui, "environment/" + source);
  tooltip(source);
}

void draw_light(Ui& ui) {
  Edits& edits = ui.state.edits;
  row_label("Environment", "Drop an .hdr or .exr file on the picture to add one");
  const bool open = ImGui::BeginCombo("##environment", environment_label(edits.environment).c_str());
  if (open) {
    for (const std::string& name : builtin_environment_names())
      environment_row(ui, name.starts_with("builtin:") ? name : "builtin:" + name);
    for (const std::string& file : ui.facts.environment_files) environment_row(ui, file);
    ImGui::EndCombo();
  } else {
    mark_item(ui, "environment");
  }
  row_label("Rotation", "Rotates the environment about the vertical; Ctrl and drag in the picture does it too");
  slider("##rotation", &edits.env_rotation_deg, -180.0f, 180.0f, "%.1f\u00b0");
  mark_item(ui, "rotation");
  row_label("Intensity", "cd/m\u00b2 per stored unit of the environment");
  slider("##intensity", &edits.env_scale, 1e-3f, 1e6f, "\u00d7 %.3g", ImGuiSliderFlags_Logarithmic);
  mark_item(ui, "intensity");
  edits.env_scale = std::max(edits.env_scale, 0.0f);
  if (!ui.facts.sun_deg) return;
  char text[64];
  std::snprintf(text, sizeof text, "%.1f\u00b0 high, at %.1f\u00b0", static_cast<double>(ui.facts.sun_deg->x),
                static_cast<double>(ui.facts.sun_deg->y));
  row_label("Sun", "Where the light of the environment is brightest: elevation, and azimuth from +Z towards +X");
  ImGui::TextUnformatted(elide(text, ImGui::GetContentRegionAvail().x).c_str());
  mark_item(ui, "sun");
}

void draw_display(Ui& ui) {
  row_label("Exposure", "Stops; the picture is multiplied by 2 to the power of it");
  const float suggested = ui.facts.suggested_exposure_ev;
  const float button = ImGui::CalcTextSize("Auto").x + 2.0f * ImGui::GetStyle().FramePadding.x;
  ImGui::SetNextItemWidth(-button - ImGui::GetStyle().ItemInnerSpacing.x);
  if (slider("##exposure", &ui.state.exposure_ev, suggested - 8.0f, suggested + 8.0f, "%+.2f EV"))
    ui.state.auto_exposure = false;
  mark_item(ui, "exposure");
  ImGui::SameLine(0.0f, ImGui::GetStyle().ItemInnerSpacing.x);
  const bool automatic = ui.state.auto_exposure;
  if (automatic) ImGui::PushStyleColor(ImGuiCol_Text, kAccent);
  if (ImGui::Button("Auto")) ui.state.auto_exposure = ui.actions.meter_exposure = true;
  if (automatic) ImGui::PopStyleColor();
  mark_item(ui, "exposure auto");
  tooltip("Meters the picture now, and again with each scene, environment and scene camera");
  row_label("Tone mapping");
  combo("##tonemap", &ui.state.tonemap, tonemap_names());
  mark_item(ui, "tonemap");
}

void draw_dent(Ui& ui) {
  float depth_cm = 100.0f * ui.state.dent_depth_m, radius_cm = 100.0f * ui.state.dent_radius_m;
  row_label("Depth", "Of a press without a drag; negative pulls out");
  if (slider("##depth", &depth_cm, -20.0f, 20.0f, "%.1f cm")) ui.state.dent_depth_m = 0.01f * depth_cm;
  mark_item(ui, "dent depth");
  row_label("Radius", "Of the part of the surface that moves");
  if (slider("##radius", &radius_cm, 1.0f, 200.0f, "%.0f cm", ImGuiSliderFlags_Logarithmic))
    ui.state.dent_radius_m = 0.01f * radius_cm;
  mark_item(ui, "dent radius");
  dim_text(ui.state.tool == Tool::dent ? "Press on a subdivision surface and drag down to push deeper, up to pull."
                                       : "D or the Dent button starts.");
}

}  // namespace

void draw_look_panel(Ui& ui) {
  if (!ui.facts.scene) return;
  if (section(ui, "Camera")) draw_cameras(ui);
  if (section(ui, "Light")) draw_light(ui);
  if (section(ui, "Display")) draw_display(ui);
  if (!ui.facts.scene->variants.empty() && section(ui, "Variant")) draw_variants(ui);
  if (section(ui, "Dent")) draw_dent(ui);
}

}  // namespace maquette::panels
