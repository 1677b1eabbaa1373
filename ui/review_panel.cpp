// Looks and camera paths of the review.
#include <algorithm>
#include <cstdio>

#include "review/review.h"
#include "ui/widgets.h"

namespace maquette::panels {

namespace {

bool same_but_names(Look a, const Look& b) {
  a.name = b.name;
  a.note = b.note;
  return canonical(a) == canonical(b);
}

/// A name in place; empty ones and those of others are refused by keeping the old one.
template <typename T>
void name_field(const char* id, std::vector<T>* things, std::size_t at) {
  char text[128];
  std::snprintf(text, sizeof text, "%s", (*things)[at].name.c_str());
  ImGui::SetNextItemWidth(-1.0f);
  if (!ImGui::InputText(id, text, sizeof text, ImGuiInputTextFlags_EnterReturnsTrue)) return;
  const auto has = [&](const T& thing) { return thing.name == text; };
  if (text[0] != 0 && std::none_of(things->begin(), things->end(), has)) (*things)[at].name = text;
}

/// Up, down and away; true when the list has changed.
template <typename T>
bool order_buttons(Ui& ui, std::vector<T>* things, std::size_t at, const std::string& what) {
  const auto button = [&](const char* label, bool enabled, const std::string& mark) {
    ImGui::SameLine(0.0f, scaled(3.0f));
    ImGui::BeginDisabled(!enabled);
    const bool pressed = ImGui::SmallButton(label);
    ImGui::EndDisabled();
    mark_item(ui, what + "/" + mark + "/" + (*things)[at].name);
    return pressed;
  };
  if (button("^", at > 0, "up")) {
    std::swap((*things)[at], (*things)[at - 1]);
    return true;
  }
  if (button("v", at + 1 < things->size(), "down")) {
    std::swap((*things)[at], (*things)[at + 1]);
    return true;
  }
  if (button("x", true, "remove")) {
    things->erase(things->begin() + static_cast<std::ptrdiff_t>(at));
    return true;
  }
  return false;
}

void draw_looks(Ui& ui) {
  EditorState& state = ui.state;
  if (ImGui::Button("Keep this look")) ui.actions.keep_look = true;
  mark_item(ui, "look/keep");
  tooltip("Keeps camera, light, materials and all else as a look (L)");
  const float buttons = scaled(80.0f);
  for (std::size_t i = 0; i < state.looks.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    const Look& look = state.looks[i];
    const float line = ImGui::GetTextLineHeight(), height = 2.0f * line;
    const auto picture = ui.facts.look_pictures.find(look.name);
    const float image = 16.0f / 9.0f * height;
    if (picture != ui.facts.look_pictures.end())
      ImGui::Image(reinterpret_cast<ImTextureID>(static_cast<std::uintptr_t>(picture->second)), {image, height});
    else
      ImGui::Dummy({image, height});
    ImGui::SameLine();
    const bool chosen = look.name == state.name;
    const std::string label = look.name + (chosen && !same_but_names(state, look) ? " *" : "");
    const float width = ImGui::GetContentRegionAvail().x - buttons;
    if (ImGui::Selectable(elide(label, width).c_str(), chosen, 0, {width, height}))
      ui.actions.go_to_look = static_cast<int>(i);
    mark_item(ui, "look/" + look.name);
    tooltip(look.note.empty() ? look.name : look.name + "\n" + look.note);
    const bool changed = order_buttons(ui, &state.looks, i, "look");
    ImGui::PopID();
    if (changed) break;
  }
  const auto at =
      std::find_if(state.looks.begin(), state.looks.end(), [&](const Look& l) { return l.name == state.name; });
  if (at == state.looks.end()) {
    dim_text(state.looks.empty() ? "A look is a state that can be gone back to."
                                 : "Page Up and Page Down change looks.");
    return;
  }
  row_label("Name", "Of the look that is chosen");
  name_field("##look name", &state.looks, static_cast<std::size_t>(at - state.looks.begin()));
  mark_item(ui, "look name");
  if (std::none_of(state.looks.begin(), state.looks.end(), [&](const Look& l) { return l.name == state.name; }))
    state.name = at->name;
  char note[512];
  std::snprintf(note, sizeof note, "%s", at->note.c_str());
  row_label("Note", "What is to be said about the look that is chosen");
  if (ImGui::InputText("##note", note, sizeof note)) at->note = state.note = note;
  mark_item(ui, "look note");
  ImGui::BeginDisabled(same_but_names(state, *at));
  if (ImGui::Button("Update")) *at = canonical(state);
  mark_item(ui, "look/update");
  tooltip("Makes the look what is shown now");
  ImGui::EndDisabled();
}

void draw_compare(Ui& ui) {
  static const char* const kHows[] = {"wiper", "side by side", "difference (FLIP)"};
  CompareView& view = ui.state.compare;
  const std::string shown = view.other.empty() ? std::string("last shown") : view.other;
  ImGui::BeginDisabled(ui.state.looks.empty());
  row_label("Compare", "The look at hand with another one, by the same camera (C)");
  if (ImGui::Checkbox("##on", &view.on) && !view.on) view.other.clear();
  mark_item(ui, "compare/on");
  ImGui::SameLine();
  ImGui::SetNextItemWidth(-FLT_MIN);
  if (ImGui::BeginCombo("##other", shown.c_str())) {
    if (ImGui::Selectable("last shown", view.other.empty())) view.other.clear();
    for (const Look& look : ui.state.looks)
      if (look.name != ui.state.name && ImGui::Selectable(look.name.c_str(), view.other == look.name)) {
        view.other = look.name;
        view.on = true;
      }
    ImGui::EndCombo();
  }
  mark_item(ui, "compare/other");
  row_label("Shown as", "B goes from one to the next; X swaps both");
  int how = static_cast<int>(view.how);
  if (ImGui::Combo("##how", &how, kHows, 3)) view.how = static_cast<CompareView::How>(how);
  mark_item(ui, "compare/how");
  ImGui::EndDisabled();
}

void draw_key(Ui& ui, PathKey* key, bool first) {
  static const char* const kEases[] = {"linear", "in", "out", "smooth"};
  const auto seconds = [&](const char* label, const char* id, const char* help, double* value) {
    auto shown = static_cast<float>(*value);
    row_label(label, help);
    if (ImGui::DragFloat(id, &shown, 0.02f, 0.0f, 3600.0f, "%.2f s", ImGuiSliderFlags_AlwaysClamp))
      *value = static_cast<double>(shown);
    mark_item(ui, std::string("key/") + label);
  };
  char name[128];
  std::snprintf(name, sizeof name, "%s", key->name.c_str());
  row_label("Key", "Its name");
  if (ImGui::InputTextWithHint("##key name", "a name", name, sizeof name)) key->name = name;
  mark_item(ui, "key/name");
  seconds("Delay", "##delay", "Rest at this key", &key->delay_s);
  seconds("Duration", "##duration", "Of the move to the next key", &key->duration_s);
  row_label("Ease", "How the move begins and ends");
  if (ImGui::BeginCombo("##ease", kEases[static_cast<int>(key->ease)])) {
    for (int i = 0; i < 4; ++i)
      if (ImGui::Selectable(kEases[i], static_cast<int>(key->ease) == i)) key->ease = static_cast<Ease>(i);
    ImGui::EndCombo();
  }
  mark_item(ui, "key/ease");
  row_label("Skip", "As if the key were not there");
  ImGui::Checkbox("##skip", &key->skip);
  mark_item(ui, "key/skip");
  row_label("Look", "From this key on");
  const char* const none = first ? "whatever is at hand" : "as before";
  if (ImGui::BeginCombo("##key look", key->look ? key->look->c_str() : none)) {
    if (ImGui::Selectable(none, !key->look)) key->look.reset();
    for (const Look& look : ui.state.looks)
      if (ImGui::Selectable(look.name.c_str(), key->look == look.name)) key->look = look.name;
    ImGui::EndCombo();
  }
  mark_item(ui, "key/look");
  const auto keyed = [&](const char* label, const char* id, std::optional<float>* value, float now,
                         const char* format) {
    bool on = value->has_value();
    row_label(label, "Changes evenly between the keys that say it");
    if (ImGui::Checkbox((std::string(id) + " on").c_str(), &on)) *value = on ? std::optional(now) : std::nullopt;
    mark_item(ui, std::string("key/") + label + " on");
    if (!*value) return;
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-1.0f);
    ImGui::DragFloat(id, &**value, 0.1f, -3600.0f, 3600.0f, format);
    mark_item(ui, std::string("key/") + label);
  };
  keyed("Light", "##key rotation", &key->env_rotation_deg, ui.state.edits.env_rotation_deg, "%.1f\u00b0");
  keyed("Exposure", "##key exposure", &key->exposure_ev, ui.state.exposure_ev, "%+.2f EV");
  if (ImGui::Button("Set the camera here")) key->camera = ui.state.camera;
  mark_item(ui, "key/camera");
}

void draw_keys(Ui& ui, CameraPath* path) {
  PathView& view = ui.state.path_view;
  const std::vector<double> times = key_times_s(*path);
  // A recorded path has many: what belongs to the chosen one stays in reach.
  constexpr std::size_t kMostShown = 6;
  const float line = ImGui::GetTextLineHeightWithSpacing();
  ImGui::PushStyleColor(ImGuiCol_ChildBg, ImVec4(0.0f, 0.0f, 0.0f, 0.0f));
  begin_list("keys", line * static_cast<float>(std::min(path->keys.size(), kMostShown)) + scaled(4.0f));
  ImGui::PopStyleColor();
  for (std::size_t i = 0; i < path->keys.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    char text[160];
    std::snprintf(text, sizeof text, "%6.2f s  %s%s", times[i],
                  path->keys[i].name.empty() ? ("key " + std::to_string(i + 1)).c_str() : path->keys[i].name.c_str(),
                  path->keys[i].skip ? " (skipped)" : "");
    const float width = ImGui::GetContentRegionAvail().x - scaled(80.0f);
    if (ImGui::Selectable(text, view.key == static_cast<int>(i), 0, {width, 0.0f})) {
      view.key = static_cast<int>(i);
      view.time_s = times[i];
      view.goes_there = true;
    }
    mark_item(ui, "key/" + std::to_string(i + 1));
    const std::optional<std::string> begins_with = path->keys.front().look;
    const bool changed = order_buttons(ui, &path->keys, i, "key");
    ImGui::PopID();
    if (!changed) continue;
    // Whichever key comes first now, the path begins in the same look.
    if (!path->keys.empty() && !path->keys.front().look) path->keys.front().look = begins_with;
    break;
  }
  ImGui::EndChild();
  if (ImGui::Button("Add this camera")) ui.actions.add_key = true;
  mark_item(ui, "key/add");
  tooltip("A key behind the chosen one (K)");
  if (view.key >= 0 && view.key < static_cast<int>(path->keys.size()))
    draw_key(ui, &path->keys[static_cast<std::size_t>(view.key)], view.key == 0);
}

void draw_playback(Ui& ui, CameraPath* edited) {
  const CameraPath& path = *edited;
  static const char* const kPlayings[] = {"once", "loop", "there and back", "backwards"};
  PathView& view = ui.state.path_view;
  const bool can_play = std::ranges::count(path.keys, false, &PathKey::skip) >= 2 && path_duration_s(path) > 0.0;
  ImGui::BeginDisabled(!can_play);
  if (toggle_button(view.playing ? "Stop" : "Play", view.playing)) ui.actions.play_path = true;
  mark_item(ui, "path/play");
  tooltip("Space");
  ImGui::SameLine();
  if (ImGui::Button("<")) ui.actions.step_path = -1;
  mark_item(ui, "path/back");
  ImGui::SameLine();
  if (ImGui::Button(">")) ui.actions.step_path = 1;
  mark_item(ui, "path/step");
  tooltip("A twenty-fifth of a second");
  ImGui::SameLine();
  ImGui::SetNextItemWidth(-1.0f);
  if (ImGui::BeginCombo("##playing", kPlayings[static_cast<int>(view.playback)])) {
    for (int i = 0; i < 4; ++i)
      if (ImGui::Selectable(kPlayings[i], static_cast<int>(view.playback) == i))
        view.playback = static_cast<Playing>(i);
    ImGui::EndCombo();
  }
  mark_item(ui, "path/playback");
  auto time_s = static_cast<float>(view.time_s);
  const float end_s = can_play ? static_cast<float>(path_duration_s(path)) : 1.0f;
  ImGui::SetNextItemWidth(-1.0f);
  if (slider("##time", &time_s, 0.0f, end_s, "%.2f s")) {
    view.time_s = static_cast<double>(time_s);
    view.goes_there = true;
  }
  mark_item(ui, "path/time");
  ImGui::EndDisabled();
  if (can_play) draw_timeline(ui, edited);
  const std::string late = std::to_string(view.late_frames);
  dim_text(view.late_frames > 0 ? late + " frames late; play renders all" : " ");
}

/// The scene's own animations, each of which makes a path.
void draw_animations(Ui& ui) {
  const std::vector<Animation>& animations = ui.facts.scene->animations;
  if (animations.empty()) return;
  row_label("Animation", "Of the scene's file: adds a path that it plays along");
  if (ImGui::BeginCombo("##animation", "add a path")) {
    for (std::size_t i = 0; i < animations.size(); ++i) {
      char label[192];
      std::snprintf(label, sizeof label, "%s  %.2f s", animations[i].name.c_str(), animations[i].duration_s);
      if (ImGui::Selectable(label)) ui.actions.add_animation = static_cast<int>(i);
      mark_item(ui, "animation/" + animations[i].name);
    }
    ImGui::EndCombo();
  }
  mark_item(ui, "animation");
}

/// What plays along the chosen path.
void draw_path_animation(Ui& ui, CameraPath* path) {
  const std::vector<Animation>& animations = ui.facts.scene->animations;
  if (animations.empty() && path->animation.empty()) return;
  row_label("Plays", "Animation of the scene that plays along the path");
  const bool open = ImGui::BeginCombo("##plays", path->animation.empty() ? "nothing" : path->animation.c_str());
  mark_item(ui, "path/plays");
  if (!open) return;
  if (ImGui::Selectable("nothing", path->animation.empty())) path->animation.clear();
  for (const Animation& animation : animations)
    if (ImGui::Selectable(animation.name.c_str(), path->animation == animation.name)) path->animation = animation.name;
  ImGui::EndCombo();
}

void draw_paths(Ui& ui) {
  EditorState& state = ui.state;
  PathView& view = state.path_view;
  if (toggle_button(view.recording ? "Stop recording" : "Record", view.recording)) ui.actions.record_path = true;
  mark_item(ui, "path/record");
  tooltip("Notes the camera while it moves");
  ImGui::SameLine();
  if (ImGui::Button("New")) ui.actions.new_path = true;
  mark_item(ui, "path/new");
  tooltip("A path that begins here");
  ImGui::SameLine();
  if (ImGui::Button("Turntable")) ui.actions.turntable = true;
  mark_item(ui, "path/turntable");
  tooltip("Once around what is looked at");
  draw_animations(ui);
  if (state.paths.empty()) return dim_text("A path moves the camera from key to key; maquette play renders it.");
  view.path = std::clamp(view.path, 0, static_cast<int>(state.paths.size()) - 1);
  for (std::size_t i = 0; i < state.paths.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    const float width = ImGui::GetContentRegionAvail().x - scaled(80.0f);
    if (ImGui::Selectable(elide(state.paths[i].name, width).c_str(), view.path == static_cast<int>(i), 0,
                          {width, 0.0f})) {
      view.path = static_cast<int>(i);
      view.key = -1;
      view.time_s = 0.0;
    }
    mark_item(ui, "path/" + state.paths[i].name);
    const bool changed = order_buttons(ui, &state.paths, i, "path");
    ImGui::PopID();
    if (changed) return;
  }
  CameraPath& path = state.paths[static_cast<std::size_t>(view.path)];
  row_label("Name", "Of the path");
  name_field("##path name", &state.paths, static_cast<std::size_t>(view.path));
  mark_item(ui, "path name");
  row_label("Closed", "The last key leads back to the first");
  ImGui::Checkbox("##closed", &path.closed);
  mark_item(ui, "path/closed");
  ImGui::SameLine();
  if (ImGui::Button("Write a file")) ui.actions.export_path = true;
  mark_item(ui, "path/export");
  tooltip("NAME.path.json beside the review; such a file can be dropped on the picture");
  draw_path_animation(ui, &path);
  draw_playback(ui, &path);
  draw_keys(ui, &path);
}

}  // namespace

void draw_review_panel(Ui& ui) {
  if (!ui.facts.scene) return;
  // Lists number their lines, each for itself.
  const bool looks = section(ui, "Looks");
  ImGui::PushID("looks");
  if (looks) draw_looks(ui);
  if (looks) draw_compare(ui);
  ImGui::PopID();
  const bool paths = section(ui, "Camera paths");
  ImGui::PushID("paths");
  if (paths) draw_paths(ui);
  ImGui::PopID();
}

}  // namespace maquette::panels
