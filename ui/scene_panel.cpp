// The node tree with search, visibility and selection.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "render/parts/parts.h"
#include "ui/widgets.h"

namespace maquette::panels {

namespace {

bool is_ancestor(const Scene& scene, int ancestor, int node) {
  for (int i = node, steps = 0; i >= 0 && steps <= static_cast<int>(scene.nodes.size()); ++steps) {
    if (i == ancestor) return true;
    i = scene.nodes[static_cast<std::size_t>(i)].parent;
  }
  return false;
}

const char* kind_of(const Scene& scene, const Node& node) {
  if (node.mesh >= 0) return scene.meshes[static_cast<std::size_t>(node.mesh)].cage ? "subdivision" : "mesh";
  if (node.patch >= 0) return "patch";
  if (node.camera >= 0) return "camera";
  if (node.light >= 0) return "light";
  return "";
}

/// The patches that represent the node as a mirror, with a colon before them.
std::string fit_of(const Ui& ui, int index) {
  if (!ui.facts.stats || !ui.facts.stats->fits.contains(index)) return "";
  return ": " + ui.facts.stats->fits.at(index);
}

void select_node(Ui& ui, int index) {
  ui.state.selected_node = index;
  const Node& node = ui.facts.scene->nodes[static_cast<std::size_t>(index)];
  if (node.mesh < 0) return;
  const Mesh& mesh = ui.facts.scene->meshes[static_cast<std::size_t>(node.mesh)];
  if (mesh.primitives.empty()) return;
  const int material = material_of(mesh.primitives.front(), variant_index(*ui.facts.scene, ui.state.edits.variant));
  if (material >= 0) ui.state.selected_material = material;
}

void visibility_box(Ui& ui, int index) {
  std::set<std::string>& hidden = ui.state.edits.hidden_nodes;
  bool shown = hidden.empty() || !hidden.contains(ui.facts.path_of(index));
  ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {scaled(1.0f), scaled(1.0f)});
  if (ImGui::Checkbox("##visible", &shown)) {
    if (shown)
      hidden.erase(ui.facts.path_of(index));
    else
      hidden.insert(ui.facts.path_of(index));
  }
  ImGui::PopStyleVar();
  tooltip("Shown, with everything below it");
  mark_item(ui, "visible/" + ui.facts.scene->nodes[static_cast<std::size_t>(index)].name);
}

/// What a part can be turned to, in an open menu.
void draw_part_menu(Ui& ui, int index) {
  const Scene& scene = *ui.facts.scene;
  if (ImGui::MenuItem("Show this alone", "I")) isolate(&ui.state, ui.facts, index);
  mark_item(ui, "isolate");
  if (ImGui::MenuItem("Show all", nullptr, false, !ui.state.edits.hidden_nodes.empty()))
    ui.state.edits.hidden_nodes.clear();
  ImGui::Separator();
  std::map<std::string, std::string>& modes = ui.state.edits.part_modes;
  const std::string path = ui.facts.path_of(index);
  const auto own = modes.find(path);
  dim_text("Shading mode of " + scene.nodes[static_cast<std::size_t>(index)].name);
  if (ImGui::MenuItem("as above", nullptr, own == modes.end())) modes.erase(path);
  mark_item(ui, "part mode/as above");
  for (const Technique& technique : ui.facts.registry->techniques) {
    if (technique.kind != TechniqueKind::mode || technique.can.traces_picture) continue;
    if (ImGui::MenuItem(technique.name.c_str(), nullptr, own != modes.end() && own->second == technique.name))
      modes[path] = technique.name;
    mark_item(ui, "part mode/" + technique.name);
  }
  ImGui::EndPopup();
}

/// At a line of the tree, by the right mouse button.
void mode_menu(Ui& ui, int index) {
  if (ImGui::BeginPopupContextItem("mode")) draw_part_menu(ui, index);
}

/// What is said of a node behind its name.
std::string notes_of(const Ui& ui, int index) {
  std::string notes = ui.facts.reflecting.contains(index) ? "  (reflects)" : "";
  const std::map<std::string, std::string>& modes = ui.state.edits.part_modes;
  const auto mode = modes.empty() ? modes.end() : modes.find(ui.facts.path_of(index));
  return mode == modes.end() ? notes : notes + "  [" + mode->second + "]";
}

/// One line; true when its children are to be drawn.
bool draw_line(Ui& ui, int index, bool leaf, bool open) {
  const Scene& scene = *ui.facts.scene;
  const Node& node = scene.nodes[static_cast<std::size_t>(index)];
  visibility_box(ui, index);
  ImGui::SameLine(0.0f, scaled(4.0f));
  ImGuiTreeNodeFlags flags = ImGuiTreeNodeFlags_OpenOnArrow | ImGuiTreeNodeFlags_OpenOnDoubleClick |
                             ImGuiTreeNodeFlags_SpanAvailWidth | (open ? ImGuiTreeNodeFlags_DefaultOpen : 0);
  if (leaf) flags |= ImGuiTreeNodeFlags_Leaf | ImGuiTreeNodeFlags_NoTreePushOnOpen;
  if (ui.state.selected_node == index) flags |= ImGuiTreeNodeFlags_Selected;
  const char* kind = kind_of(scene, node);
  const bool reflects = ui.facts.reflecting.contains(index);
  const bool expanded = ImGui::TreeNodeEx("##node", flags, "%s%s", node.name.empty() ? "(no name)" : node.name.c_str(),
                                          notes_of(ui, index).c_str());
  if ((ImGui::IsItemClicked() && !ImGui::IsItemToggledOpen()) || pressed_by_key()) select_node(ui, index);
  mark_item(ui, "node/" + node.name);
  mode_menu(ui, index);
  if (*kind) tooltip(node.name + "\n" + kind + (reflects ? "\nreflects" + fit_of(ui, index) : ""));
  return expanded && !leaf;
}

void draw_tree(Ui& ui, int index, int depth) {
  const Scene& scene = *ui.facts.scene;
  const Node& node = scene.nodes[static_cast<std::size_t>(index)];
  ImGui::PushID(index);
  const int reveal = ui.state.reveal_node;
  if (reveal >= 0 && reveal != index && is_ancestor(scene, index, reveal)) ImGui::SetNextItemOpen(true);
  const bool expanded = draw_line(ui, index, node.children.empty(), depth == 0 && scene.roots.size() == 1);
  if (reveal == index) {
    ImGui::SetScrollHereY();
    ui.state.reveal_node = -1;
  }
  if (expanded) {
    for (const int child : node.children) draw_tree(ui, child, depth + 1);
    ImGui::TreePop();
  }
  ImGui::PopID();
}

void draw_matches(Ui& ui) {
  const Scene& scene = *ui.facts.scene;
  bool any = false;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    if (!contains(scene.nodes[i].name, ui.state.node_search.data())) continue;
    any = true;
    ImGui::PushID(static_cast<int>(i));
    draw_line(ui, static_cast<int>(i), true, false);
    ImGui::PopID();
  }
  if (!any) dim_text("No node has this in its name.");
}

/// The section plane: its axis, where it cuts, and which side is seen.
void draw_section(Ui& ui) {
  static const char* const kAxes[] = {"none", "x", "y", "z", "as given"};
  glm::vec4& section = ui.state.edits.section;
  int axis = 0, sign = 1;
  if (section != glm::vec4(0.0f)) {
    axis = 4;
    for (int i = 0; i < 3; ++i)
      if (std::abs(section[i]) == 1.0f) axis = i + 1, sign = section[i] > 0.0f ? 1 : -1;
  }
  const Bounds& bounds = ui.facts.bounds;
  row_label("Section", "Cuts away what the eye sees beyond a plane; shadows, light and mirror images stay whole");
  const float flip = ImGui::CalcTextSize("Flip").x + 2.0f * ImGui::GetStyle().FramePadding.x;
  ImGui::SetNextItemWidth(-flip - ImGui::GetStyle().ItemSpacing.x);
  if (ImGui::BeginCombo("##axis", kAxes[axis])) {
    for (int i = 0; i < 4; ++i) {
      if (ImGui::Selectable(kAxes[i], axis == i)) {
        section = glm::vec4(0.0f);
        if (i > 0) {
          section[i - 1] = 1.0f;
          section.w = bounds.empty() ? 0.0f : bounds.center()[i - 1];
        }
      }
      mark_item(ui, std::string("section/") + kAxes[i]);
    }
    ImGui::EndCombo();
  }
  mark_item(ui, "section");
  ImGui::SameLine();
  ImGui::BeginDisabled(axis == 0);
  if (ImGui::Button("Flip")) section = -section, sign = -sign;
  mark_item(ui, "section/flip");
  ImGui::EndDisabled();
  tooltip("Shows the other side");
  if (axis == 0) return;
  const float middle = axis < 4 && !bounds.empty() ? bounds.center()[axis - 1] : 0.0f;
  const float reach = axis < 4 && !bounds.empty() ? 0.5f * (bounds.max - bounds.min)[axis - 1] : 10.0f;
  float at = static_cast<float>(sign) * section.w;
  row_label("Cut at", "Along the axis, metres; Ctrl+click types a value");
  if (slider("##cut", &at, middle - reach, middle + reach, "%.3f m")) section.w = static_cast<float>(sign) * at;
  mark_item(ui, "section/cut");
}

/// The turn of the chosen node about the vertical; others that a command or a file gave stay.
void draw_turn(Ui& ui) {
  const Scene& scene = *ui.facts.scene;
  if (ui.state.selected_node < 0 || ui.state.selected_node >= static_cast<int>(scene.nodes.size())) return;
  const glm::vec3 up(0.0f, 1.0f, 0.0f);
  const std::string path = ui.facts.path_of(ui.state.selected_node);
  std::vector<NodeTurn>& turns = ui.state.edits.turns;
  const auto found = std::ranges::find_if(turns, [&](const NodeTurn& t) { return t.node == path && t.axis == up; });
  float angle = found == turns.end() ? 0.0f : found->angle_deg;
  row_label("Turn", "The chosen node with what is below it, about the vertical through its origin");
  const float more = ImGui::GetFrameHeight();
  ImGui::SetNextItemWidth(-more - ImGui::GetStyle().ItemSpacing.x);
  if (slider("##turn", &angle, -180.0f, 180.0f, "%.1f\u00b0")) {
    if (found == turns.end())
      turns.push_back({path, up, angle});
    else if (angle == 0.0f)
      turns.erase(found);
    else
      found->angle_deg = angle;
  }
  mark_item(ui, "turn");
  ImGui::SameLine();
  if (ImGui::Button("...", {more, 0.0f})) ImGui::OpenPopup("part");
  mark_item(ui, "part");
  tooltip("Shows the chosen part alone; its shading mode");
  if (ImGui::BeginPopup("part")) draw_part_menu(ui, ui.state.selected_node);
}

}  // namespace

void draw_scene_panel(Ui& ui) {
  if (!ui.facts.scene) return;
  const Scene& scene = *ui.facts.scene;
  const bool searching = search_box(ui, "Search nodes", ui.state.node_search.data(), ui.state.node_search.size());
  const float rows =
      (ui.state.edits.section == glm::vec4(0.0f) ? 1.0f : 2.0f) + (ui.state.selected_node >= 0 ? 1.0f : 0.0f);
  const float foot = ImGui::GetTextLineHeightWithSpacing() + rows * ImGui::GetFrameHeightWithSpacing();
  if (begin_list("tree", ImGui::GetContentRegionAvail().y - foot - scaled(4.0f))) {
    if (searching) {
      draw_matches(ui);
    } else {
      for (const int root : scene.roots) draw_tree(ui, root, 0);
    }
  }
  ImGui::EndChild();
  draw_section(ui);
  draw_turn(ui);
  const std::size_t hidden = ui.state.edits.hidden_nodes.size();
  dim_text(std::to_string(scene.nodes.size()) + " nodes" +
           (hidden > 0 ? ", " + std::to_string(hidden) + " hidden" : std::string()));
  if (hidden > 0) {
    ImGui::SameLine();
    if (ImGui::SmallButton("Show all")) ui.state.edits.hidden_nodes.clear();
    mark_item(ui, "show all");
  }
}

}  // namespace maquette::panels

namespace maquette {

void isolate(EditorState* state, const EditorFacts& facts, int kept) {
  const Scene& scene = *facts.scene;
  std::set<std::string>& hidden = state->edits.hidden_nodes;
  hidden.clear();
  for (int i = 0; i < static_cast<int>(scene.nodes.size()); ++i) {
    const Node& node = scene.nodes[static_cast<std::size_t>(i)];
    // A branch is hidden at its top.
    const bool beside = !panels::is_ancestor(scene, i, kept) && !panels::is_ancestor(scene, kept, i);
    const bool top = node.parent < 0 || panels::is_ancestor(scene, node.parent, kept);
    if (beside && top && node.light < 0 && node.camera < 0) hidden.insert(facts.path_of(i));
  }
}

}  // namespace maquette
