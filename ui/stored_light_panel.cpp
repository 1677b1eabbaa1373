// What a bake has stored for a point of the picture.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>

#include "ui/widgets.h"

namespace maquette::panels {

namespace {

constexpr float kMostDecades = 3.0f;

std::string percent_text(double share) {
  char text[32];
  const double percent = 100.0 * share;
  std::snprintf(text, sizeof text, "%.*f %%", percent < 0.95 ? 2 : percent < 9.5 ? 1 : 0, percent);
  return text;
}

/// Curves of the error over clusters, one for each count of components, both axes logarithmic.
void draw_curves(Ui& ui, const CompressionTable& table) {
  const ImVec2 at = ImGui::GetCursorScreenPos();
  const float label = ImGui::CalcTextSize("1000 %").x + scaled(4.0f), line = ImGui::GetTextLineHeight();
  const float name = ImGui::CalcTextSize("16 comp.").x + scaled(4.0f);
  const ImVec2 size(ImGui::GetContentRegionAvail().x, scaled(130.0f) + line);
  const ImVec2 low(at.x + label, at.y + size.y - line), high(at.x + size.x - name, at.y + 0.5f * line);
  ImGui::Dummy(size);
  mark_item(ui, "inspection/stored/chart");
  double most = 0.0, least = 1.0;
  for (const double e : table.errors)
    if (e > 0.0) most = std::max(most, e), least = std::min(least, e);
  if (!(most > 0.0)) return;
  const float top = std::ceil(std::log10(static_cast<float>(most)) * 2.0f) / 2.0f,
              bottom = std::max(std::floor(std::log10(static_cast<float>(least)) * 2.0f) / 2.0f, top - kMostDecades);
  const float right = std::log2(static_cast<float>(std::max(table.clusters.back(), 2)));
  const auto place = [&](std::size_t component, std::size_t cluster) {
    const float x = std::log2(static_cast<float>(table.clusters[cluster])) / right,
                e = std::log10(std::max(static_cast<float>(table.error(component, cluster)), 1e-9f));
    const float y = std::clamp((e - bottom) / std::max(top - bottom, 0.1f), 0.0f, 1.0f);
    return ImVec2(low.x + x * (high.x - low.x), low.y + y * (high.y - low.y));
  };
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const ImU32 dim = ImGui::GetColorU32(ImGuiCol_TextDisabled), grid = ImGui::GetColorU32(ImGuiCol_Separator);
  const ImU32 color = ImGui::GetColorU32(ImGuiCol_PlotLines);
  char text[32];
  for (float decade = bottom; decade <= top + 0.01f; decade += 0.5f) {
    const float y = low.y + (decade - bottom) / std::max(top - bottom, 0.1f) * (high.y - low.y);
    draw.AddLine({low.x, y}, {high.x, y}, grid);
    draw.AddText({at.x, y - 0.5f * line}, dim, percent_text(std::pow(10.0, static_cast<double>(decade))).c_str());
  }
  for (std::size_t k = 0; k < table.clusters.size(); ++k) {
    std::snprintf(text, sizeof text, "%d", table.clusters[k]);
    draw.AddText({place(0, k).x - 0.5f * ImGui::CalcTextSize(text).x, low.y + scaled(2.0f)}, dim, text);
  }
  for (std::size_t c = 0; c < table.components.size(); ++c) {
    for (std::size_t k = 0; k < table.clusters.size(); ++k) {
      draw.AddCircleFilled(place(c, k), scaled(2.5f), color);
      if (k > 0) draw.AddLine(place(c, k - 1), place(c, k), color, scaled(1.5f));
    }
    const ImVec2 end = place(c, table.clusters.size() - 1);
    std::snprintf(text, sizeof text, "%d comp.", table.components[c]);
    draw.AddText({end.x + scaled(6.0f), end.y - 0.5f * line}, dim, text);
  }
}

void draw_table(Ui& ui, const CompressionTable& table) {
  draw_curves(ui, table);
  dim_text("RMS that compression brings, of the mean, over clusters (" + std::to_string(table.vectors) + " texels).");
  if (!ImGui::BeginTable("##errors", static_cast<int>(table.clusters.size()) + 1)) return;
  ImGui::TableNextColumn();
  dim_text("comp.");
  for (const int clusters : table.clusters) {
    ImGui::TableNextColumn();
    dim_text(std::to_string(clusters));
  }
  for (std::size_t c = 0; c < table.components.size(); ++c) {
    ImGui::TableNextColumn();
    dim_text(std::to_string(table.components[c]));
    for (std::size_t k = 0; k < table.clusters.size(); ++k) {
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(percent_text(table.error(c, k)).c_str());
    }
  }
  ImGui::EndTable();
}

void draw_compression(Ui& ui) {
  const StoredLightFacts& facts = ui.facts.stored_light;
  if (facts.tabulating) {
    ImGui::ProgressBar(static_cast<float>(*facts.tabulating), ImVec2(-1.0f, 0.0f));
    if (ImGui::Button("Stop")) ui.actions.inspection.stop_tabulating = true;
    mark_item(ui, "stored light/stop");
    return;
  }
  if (facts.table) {
    draw_table(ui, *facts.table);
    return;
  }
  if (ImGui::Button("Error over clusters and components")) ui.actions.inspection.tabulate_stored = true;
  mark_item(ui, "inspection/stored/tabulate");
  tooltip("Compresses what leaves the texels in several ways, which takes some seconds");
}

}  // namespace

void draw_stored_light(Ui& ui) {
  const StoredLightFacts& facts = ui.facts.stored_light;
  const bool on = ui.state.tool == Tool::stored;
  if (toggle_button("Pick a point", on)) ui.state.tool = on ? Tool::camera : Tool::stored;
  mark_item(ui, "inspection/stored");
  tooltip("Then click on a surface: the light that its texel stores, by direction; Esc leaves");
  if (!facts.status.empty()) dim_text(facts.status);
  draw_rows(facts.values);
  const float gap = ImGui::GetStyle().ItemSpacing.x, room = ImGui::GetContentRegionAvail().x;
  const float side = std::min(0.5f * (room - gap), scaled(160.0f));
  for (std::size_t i = 0; i < facts.pictures.size(); ++i) {
    if (i % 2 == 1) ImGui::SameLine();
    ImGui::BeginGroup();
    dim_text(facts.pictures[i].name);
    ImGui::Image(reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(facts.pictures[i].texture)), {side, side});
    mark_item(ui, "inspection/stored/" + facts.pictures[i].name);
    ImGui::EndGroup();
  }
  if (!facts.pictures.empty())
    dim_text("Discs: directions of the texel's frame, its normal in the middle, the horizon at the rim.");
  if (facts.can_tabulate) draw_compression(ui);
}

}  // namespace maquette::panels
