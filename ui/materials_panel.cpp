// The scene's materials, and the library that replaces one of them by a click.
#include <algorithm>
#include <filesystem>

#include "render/btf/builtin_geometry.h"
#include "scenes/brdf.h"
#include "ui/widgets.h"

namespace maquette::panels {

namespace {

constexpr const char* kDraggedSource = "material source";

std::string source_label(const std::string& source) {
  if (source.empty()) return "from the file";
  if (source == "builtin:glass") return "Glass pane";
  if (source.starts_with("builtin:")) {
    for (const BuiltinBrdf& brdf : builtin_brdfs())
      if (source.compare(8, std::string::npos, brdf.name) == 0) return brdf.label;
    for (const BuiltinGeometry& btf : builtin_geometries())
      if (source.compare(8, std::string::npos, btf.name) == 0) return btf.label;
  }
  return std::filesystem::path(source).stem().string();
}

/// The present source of the material.
std::string current_source(const Ui& ui, const Material& material) {
  const auto found = ui.state.edits.materials.find(material.name);
  return found != ui.state.edits.materials.end() ? found->second : material.measured;
}

/// A ball with the BRDF if its picture is ready, else a square of the colour.
void draw_swatch(const Ui& ui, const std::string& source, const glm::vec4& color, const ImVec2& at, float side) {
  ImDrawList* list = ImGui::GetWindowDrawList();
  if (ui.facts.swatches) {
    if (const auto found = ui.facts.swatches->find(source); found != ui.facts.swatches->end()) {
      list->AddImage(reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(found->second)), at,
                     {at.x + side, at.y + side});
      return;
    }
  }
  const auto channel = [](float linear) { return std::pow(std::clamp(linear, 0.0f, 1.0f), 1.0f / 2.2f); };
  const ImVec4 shown(channel(color.r), channel(color.g), channel(color.b), 1.0f);
  const float inset = scaled(3.0f);
  list->AddRectFilled({at.x + inset, at.y + inset}, {at.x + side - inset, at.y + side - inset},
                      ImGui::ColorConvertFloat4ToU32(shown), scaled(3.0f));
}

/// One selectable row with a swatch, a name and a dimmed remark at the right.
bool swatch_row(const Ui& ui, const std::string& label, const std::string& remark, const std::string& source,
                const glm::vec4& color, bool selected) {
  const float height = scaled(26.0f);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float width = ImGui::GetContentRegionAvail().x;
  const bool clicked = ImGui::Selectable("##row", selected, 0, {0.0f, height});
  draw_swatch(ui, source, color, {at.x + scaled(2.0f), at.y}, height);
  ImDrawList* list = ImGui::GetWindowDrawList();
  const float text_y = at.y + 0.5f * (height - ImGui::GetTextLineHeight());
  const float text_x = at.x + height + scaled(9.0f);
  const float end = at.x + width - scaled(4.0f);
  const std::string right = elide(remark, 0.52f * width);
  const float right_width = remark.empty() ? 0.0f : ImGui::CalcTextSize(right.c_str()).x + scaled(8.0f);
  list->AddText({text_x, text_y}, ImGui::GetColorU32(ImGuiCol_Text), elide(label, end - right_width - text_x).c_str());
  if (!remark.empty())
    list->AddText({end - right_width + scaled(8.0f), text_y}, ImGui::ColorConvertFloat4ToU32(kDim), right.c_str());
  return clicked;
}

void draw_material_list(Ui& ui) {
  const Scene& scene = *ui.facts.scene;
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    const Material& material = scene.materials[i];
    if (!contains(material.name, ui.state.material_search.data())) continue;
    const std::string source = current_source(ui, material);
    const bool selected = ui.state.selected_material == static_cast<int>(i);
    ImGui::PushID(static_cast<int>(i));
    const bool changed = ui.state.edits.materials.contains(material.name);
    const std::string remark = changed || !material.measured.empty() ? source_label(source) : std::string();
    if (swatch_row(ui, material.name.empty() ? "(no name)" : material.name, remark, source, material.base_color,
                   selected))
      ui.state.selected_material = static_cast<int>(i);
    mark_item(ui, "material/" + material.name);
    if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenBlockedByActiveItem))
      ui.frame.hovered_material = static_cast<int>(i);
    tooltip(material.name + "\n" + source_label(source) + (source.empty() ? "" : "\n" + source) +
            "\nDrop a .binary file here to replace it");
    if (selected && ui.state.reveal_material) {
      ImGui::SetScrollHereY();
      ui.state.reveal_material = false;
    }
    ImGui::PopID();
  }
}

void library_row(Ui& ui, const Material& material, const std::string& label, const std::string& source,
                 const std::string& help) {
  ImGui::PushID(source.c_str());
  const glm::vec4 color = source == "builtin:glass" ? glm::vec4(0.25f, 0.32f, 0.34f, 1.0f) : glm::vec4(0.18f);
  if (swatch_row(ui, label, {}, source, color, current_source(ui, material) == source))
    assign_source(&ui.state, material, source);
  mark_item(ui, "library/" + source);
  if (ImGui::BeginDragDropSource()) {
    ImGui::SetDragDropPayload(kDraggedSource, source.c_str(), source.size() + 1);
    ImGui::TextUnformatted(label.c_str());
    ImGui::EndDragDropSource();
  }
  tooltip(help);
  ImGui::PopID();
}

void draw_library(Ui& ui, const Material& material) {
  for (const BuiltinBrdf& brdf : builtin_brdfs())
    library_row(ui, material, brdf.label, "builtin:" + brdf.name, brdf.label + "\n" + brdf.model);
  for (const BuiltinGeometry& btf : builtin_geometries())
    library_row(ui, material, btf.label, "builtin:" + btf.name,
                btf.label + "\n" + btf.model + "\nMade when first wanted, in minutes; then kept");
  library_row(ui, material, "Glass pane", "builtin:glass", "A thin pane that transmits and does not cast shadows");
  for (const std::string& file : ui.facts.brdf_files)
    library_row(ui, material, std::filesystem::path(file).stem().string(), file, file);
}

}  // namespace

void draw_materials_panel(Ui& ui) {
  if (!ui.facts.scene) return;
  const Scene& scene = *ui.facts.scene;
  search_box(ui, "Search materials", ui.state.material_search.data(), ui.state.material_search.size());
  const float room = ImGui::GetContentRegionAvail().y;
  const bool chosen =
      ui.state.selected_material >= 0 && ui.state.selected_material < static_cast<int>(scene.materials.size());
  const float list_height = std::round(chosen ? 0.42f * room : room - ImGui::GetTextLineHeightWithSpacing() * 2.5f);
  if (begin_list("list", list_height)) draw_material_list(ui);
  ImGui::EndChild();
  if (!chosen) {
    dim_text("Choose a material here or click on a surface, then give it a paint or a trim.");
    return;
  }
  const Material& material = scene.materials[static_cast<std::size_t>(ui.state.selected_material)];
  ImGui::AlignTextToFramePadding();
  const float button = ImGui::CalcTextSize("Restore").x + 2.0f * ImGui::GetStyle().FramePadding.x;
  const float width = ImGui::GetContentRegionAvail().x;
  ImGui::TextUnformatted(elide(material.name, width - button - scaled(8.0f)).c_str());
  ImGui::SameLine(width - button);
  ImGui::BeginDisabled(!ui.state.edits.materials.contains(material.name));
  if (ImGui::Button("Restore")) ui.state.edits.materials.erase(material.name);
  mark_item(ui, "restore");
  ImGui::EndDisabled();
  tooltip("Back to what the file says");
  if (begin_list("library", 0.0f)) draw_library(ui, material);
  ImGui::EndChild();
}

std::string dropped_source(const Ui& ui) {
  const ImGuiPayload* payload = ImGui::GetDragDropPayload();
  if (!payload || !payload->IsDataType(kDraggedSource) || !ImGui::IsMouseReleased(ImGuiMouseButton_Left)) return {};
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  const bool somewhere = ui.frame.layout.picture.contains(mouse.x, mouse.y) || ui.frame.hovered_material >= 0;
  return somewhere ? static_cast<const char*>(payload->Data) : std::string();
}

}  // namespace maquette::panels

namespace maquette {

void assign_source(EditorState* state, const Material& material, const std::string& source) {
  if (source == material.measured || source.empty())
    state->edits.materials.erase(material.name);
  else
    state->edits.materials[material.name] = source;
}

}  // namespace maquette
