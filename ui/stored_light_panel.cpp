// What a bake has stored for a point of the picture.
#include <algorithm>
#include <cstdint>

#include "ui/widgets.h"

namespace maquette::panels {

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
}

}  // namespace maquette::panels
