// The bakes that the frame wants, as a section of the tab Frame: what is there, what is in work, and how long it takes.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <sstream>

#include "render/frame/vocabulary.h"
#include "render/technique/registry.h"
#include "ui/bake_state.h"
#include "ui/widgets.h"

namespace maquette::panels {

namespace {

/// A bake that can be stopped has a setting NAME.run with the choices auto and hold; one of chosen parts NAME.parts,
/// names of nodes with semicolons between.
bool has_setting(const Registry& registry, const std::string& setting) {
  for (const Technique& technique : registry.techniques)
    for (const SettingDeclaration& s : technique.settings)
      if (s.name == setting) return true;
  return false;
}

/// What a bake of the scene changes in the picture; bakes that are not listed are those of the mode that has their
/// name.
const std::map<std::string, const char*>& changes_of_bakes() {
  static const std::map<std::string, const char*> kChanges = {
      {"visibility", "shadows of the sky, which come with indirect light"},
      {"shadow_rays", "shadows of suns and lamps, at every point"},
      {"indirect", "shadows of the sky, and light that other surfaces send"},
      {words::kOctree, "what mirrors and panes show, and shadows by rays"},
      {"cell_brdfs", "gloss of what mirrors and panes show"},
      {"patch_fit", "mirror images in curved parts, which are hatched or absent now"},
  };
  return kChanges;
}

/// Names with semicolons between, less one.
std::string without(const std::string& names, const std::string& name) {
  std::string rest;
  std::istringstream in(names);
  for (std::string one; std::getline(in, one, ';');)
    if (one != name) rest += (rest.empty() ? "" : ";") + one;
  return rest;
}

/// Which parts it is made of: all, or those that were clicked in the picture or the tree and added here.
void draw_parts(Ui& ui, const std::string& bake) {
  const std::string setting = bake + ".parts", parts = ui.state.settings.get_string(setting);
  const int node = ui.state.selected_node;
  const std::string chosen = node >= 0 && ui.facts.scene && node < static_cast<int>(ui.facts.scene->nodes.size())
                                 ? ui.facts.scene->nodes[static_cast<std::size_t>(node)].name
                                 : std::string();
  value_row("Parts", parts.empty() ? "all that the mode shades" : parts);
  const std::string others = without(parts, chosen);
  const bool there = !chosen.empty() && others != parts;
  ImGui::BeginDisabled(chosen.empty() || (there && others.empty()));
  if (ImGui::Button(there           ? "Leave the chosen part out"
                    : parts.empty() ? "Only the chosen part"
                                    : "Add the chosen part"))
    ui.state.settings.set(setting, there ? others : parts.empty() ? chosen : parts + ";" + chosen);
  ImGui::EndDisabled();
  mark_item(ui, (there ? "parts/remove/" : "parts/add/") + bake);
  tooltip(chosen.empty() ? std::string("Choose one first: click on it in the picture or in the tab Scene")
          : there        ? "The default mode is to shade " + chosen
                         : "The bake is to hold light for " + chosen);
  if (parts.empty()) return;
  ImGui::SameLine();
  if (ImGui::Button("All parts")) ui.state.settings.set(setting, std::string());
  mark_item(ui, "parts/all/" + bake);
}

void draw_bake(Ui& ui, const std::string& name, const BakeStatus& bake) {
  const auto work = std::find_if(ui.facts.background.begin(), ui.facts.background.end(),
                                 [&](const BackgroundWork& w) { return w.what == name; });
  const bool busy = work != ui.facts.background.end();
  const std::string setting = name + ".run";
  const bool stops = has_setting(*ui.facts.registry, setting);
  const bool held = stops && ui.state.settings.get_string(setting) == "hold";
  ImGui::PushID(name.c_str());
  value_row(name.c_str(), bake_state_text(bake, busy, held));
  // Controls first: what comes and goes below does not move them.
  if (stops) {
    if (ImGui::Button(held ? "Bake" : busy ? "Stop" : "Hold"))
      ui.state.settings.set(setting, std::string(held ? "auto" : "hold"));
    mark_item(ui, (held ? "bake/" : "stop/") + name);
    tooltip(held ? "Makes what is missing or no longer as the scene is"
                 : "Keeps what is there whatever changes, and says what has changed");
  }
  if (has_setting(*ui.facts.registry, name + ".parts")) draw_parts(ui, name);
  if (busy) {
    char done[64];
    const auto left = ui.facts.seconds_left.find(name);
    std::snprintf(done, sizeof(done), "%.0f %%%s", std::floor(100.0 * work->fraction),
                  left == ui.facts.seconds_left.end() ? "" : (", " + time_left_text(left->second)).c_str());
    ImGui::ProgressBar(static_cast<float>(work->fraction), ImVec2(-1.0f, 0.0f), done);
    const std::string change = change_text(*ui.facts.registry, name, bake.ready);
    if (!change.empty()) dim_text("It will change: " + change + ".");
  }
  for (const std::string& note : bake.notes) dim_text(note);
  ImGui::PopID();
}

}  // namespace

std::string bake_state_text(const BakeStatus& bake, bool busy, bool held) {
  if (bake.state == BakeState::failed) return "failed; see the messages";
  if (bake.state == BakeState::partial) return held && !busy ? "stopped; a part is shown" : "in work; a part is shown";
  if (busy) return bake.ready ? "in work; the last one is shown" : "in work";
  if (bake.ready) return held ? bake.notes.empty() ? "held" : "held; the last one is shown" : "ready";
  return held ? "stopped; nothing is baked" : "not there";
}

std::string time_left_text(double seconds) {
  char text[32];
  if (seconds < 90.0)
    std::snprintf(text, sizeof(text), "%.0f s left", std::ceil(seconds));
  else
    std::snprintf(text, sizeof(text), "%.0f min left", std::ceil(seconds / 60.0));
  return text;
}

std::string bake_effect(const Registry& registry, const std::string& bake) {
  const auto known = changes_of_bakes().find(bake);
  if (known != changes_of_bakes().end()) return known->second;
  const bool of_mode = std::ranges::any_of(registry.techniques, [&](const Technique& t) { return t.name == bake; });
  return of_mode ? "all light that mode " + bake + " shows" : "";
}

std::string change_text(const Registry& registry, const std::string& bake, bool last_is_shown) {
  const std::string effect = bake_effect(registry, bake);
  if (effect.empty() || changes_of_bakes().contains(bake)) return effect;
  return effect + "; " + (last_is_shown ? "the last one" : "a preview") + " is shown now";
}

void draw_bakes(Ui& ui) {
  const auto bakes = ui.facts.stats->status.bakes();
  if (bakes.empty() || !section(ui, "Bakes")) return;
  for (const auto& [name, bake] : bakes) draw_bake(ui, name, bake);
}

}  // namespace maquette::panels
