// The bars across the window: tools on top, figures at the bottom, unread messages above them.
#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "review/review.h"
#include "ui/widgets.h"

namespace maquette::panels {

namespace {

constexpr int kMaxStripLines = 3;
constexpr ImGuiSelectableFlags kStaysOpen = ImGuiSelectableFlags_DontClosePopups;
constexpr float kCameraWidth = 118.0f;
constexpr float kLeastWork = 60.0f;  // of the line that says what is in work

std::string scene_title(const EditorFacts& facts) {
  if (!facts.scene) return "no scene";
  const std::string& name = facts.scene->name;
  if (name.starts_with("builtin:")) return name.substr(8);
  return std::filesystem::path(name).filename().string();
}

/// Folders and files, one below the other; the file that is chosen, else empty.
std::string draw_browser(Ui& ui) {
  namespace fs = std::filesystem;
  FileBrowser& browser = ui.state.browser;
  if (browser.folder.empty()) browser = browse_folder(".");
  const fs::path folder = browser.folder;
  dim_text(browser.folder);
  std::string chosen, next;
  const float room = std::min(scaled(220.0f), 0.4f * ImGui::GetIO().DisplaySize.y);
  const float width = std::min(scaled(530.0f), ImGui::GetIO().DisplaySize.x - scaled(60.0f));
  if (begin_list("files", room, width)) {
    if (folder.has_parent_path() && folder != folder.root_path() && ImGui::Selectable("..", false, kStaysOpen))
      next = folder.parent_path().string();
    mark_item(ui, "browse/..");
    for (const std::string& name : browser.folders) {
      if (ImGui::Selectable((name + "/").c_str(), false, kStaysOpen)) next = (folder / name).string();
      mark_item(ui, "browse/" + name);
    }
    for (const std::string& name : browser.files) {
      if (ImGui::Selectable(name.c_str())) chosen = (folder / name).string();
      mark_item(ui, "browse/" + name);
    }
    if (browser.files.empty()) dim_text("no scene, review, path, environment or material here");
  }
  ImGui::EndChild();
  if (!next.empty()) browser = browse_folder(next);
  if (!chosen.empty()) ImGui::CloseCurrentPopup();
  return chosen;
}

/// A popup with one text field, which gets the keyboard, and a button; true when the text was entered.
/// With `browsed`, files are offered, and a chosen one stands there.
bool path_popup(Ui& ui, const char* title, bool* open, const char* hint, const char* button,
                std::string* browsed = nullptr) {
  constexpr int kFocusFrames = 4;  // ImGui takes two or three to hand the keyboard over
  if (*open) ImGui::OpenPopup(title);
  if (*open) ui.state.browser.folder.clear();  // files may have come since
  *open = false;
  if (!ImGui::BeginPopup(title)) return false;
  ImGui::TextUnformatted(title);
  dim_text(hint);
  int* age = ImGui::GetStateStorage()->GetIntRef(ImGui::GetID("age"));
  *age = ImGui::IsWindowAppearing() ? 0 : *age + 1;
  if (*age == 0) ImGui::SetKeyboardFocusHere();
  ImGui::SetNextItemWidth(std::min(scaled(460.0f), ImGui::GetIO().DisplaySize.x - scaled(120.0f)));
  bool entered = ImGui::InputText("##path", ui.state.path.data(), ui.state.path.size(),
                                  ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll);
  if (*age < kFocusFrames && !ImGui::IsItemActive() && !entered) ui.frame.awaits_field = true;
  mark_item(ui, "dialog/path");
  ImGui::SameLine();
  entered = (ImGui::Button(button) || entered) && ui.state.path[0] != 0;
  mark_item(ui, std::string("dialog/") + button);
  if (browsed) *browsed = draw_browser(ui);
  if (entered) ImGui::CloseCurrentPopup();
  ImGui::EndPopup();
  return entered;
}

void draw_open_popup(Ui& ui) {
  std::string browsed;
  if (path_popup(ui, "Path of a scene, an environment or a measured material", &ui.state.open_path_popup,
                 ".glb .gltf | .hdr .exr | .binary | .json | builtin:NAME (files can be dropped as well)", "Open",
                 &browsed))
    ui.actions.open_path = ui.state.path.data();
  if (!browsed.empty()) ui.actions.open_path = browsed;
}

void draw_save_popup(Ui& ui) {
  if (!path_popup(ui, "Name of the review", &ui.state.save_path_popup,
                  "NAME.maquette.json: scene, looks and paths, and all that is changed", "Save"))
    return;
  ui.actions.save_path = ui.state.path.data();
  if (!is_review_file(ui.actions.save_path)) ui.actions.save_path += ".maquette.json";
}

void draw_camera_combo(Ui& ui) {
  ImGui::SetNextItemWidth(scaled(kCameraWidth));
  if (!ImGui::BeginCombo("##camera", "Cameras")) {
    mark_item(ui, "cameras");
    tooltip("Scene cameras, also on the keys 1 to 9");
    return;
  }
  mark_item(ui, "cameras");
  if (ui.facts.cameras.empty()) dim_text("the scene has none");
  for (std::size_t i = 0; i < ui.facts.cameras.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    const std::string key = i < 9 ? std::to_string(i + 1) + "   " : "    ";
    if (ImGui::Selectable((key + ui.facts.cameras[i]).c_str())) ui.actions.go_to_camera = static_cast<int>(i);
    ImGui::PopID();
  }
  ImGui::EndCombo();
}

}  // namespace

namespace {

float button_width(const char* label) { return ImGui::CalcTextSize(label).x + 2.0f * ImGui::GetStyle().FramePadding.x; }

/// Opens or closes a side; where both have no room, the one that was opened last is shown.
void toggle_side(EditorState* state, bool right, bool shown) {
  (right ? state->right_open : state->left_open) = !shown;
  if (!shown) state->right_first = right;
}

void side_button(Ui& ui, bool right, const char* tip) {
  const bool shown = right ? ui.frame.layout.right_shown : ui.frame.layout.left_shown;
  const bool points_right = right == shown;
  ImGui::PushID(right);
  if (ImGui::Button(points_right ? glyph("\u25b8", ">") : glyph("\u25c2", "<"), {ImGui::GetFrameHeight(), 0.0f}))
    toggle_side(&ui.state, right, shown);
  ImGui::PopID();
  mark_item(ui, right ? "toggle/right" : "toggle/left");
  tooltip(tip);
}

void draw_undo(Ui& ui, const char* label, bool can, bool* action, const char* mark, const char* tip) {
  ImGui::BeginDisabled(!can);
  if (ImGui::Button(label)) *action = true;
  mark_item(ui, mark);
  ImGui::EndDisabled();
  tooltip(tip);
}

/// What has no room is in the menu alone.
void draw_tools(Ui& ui, float end) {
  EditorState& state = ui.state;
  float x = ImGui::GetItemRectMax().x - ImGui::GetWindowPos().x;
  bool room = true;
  const auto fits = [&](float width) {
    room = room && x + ImGui::GetStyle().ItemSpacing.x + width <= end;
    if (!room) return false;
    x += ImGui::GetStyle().ItemSpacing.x + width;
    ImGui::SameLine();
    return true;
  };
  if (fits(button_width("Open..."))) {
    if (ImGui::Button("Open...")) state.start_popup = true;
    mark_item(ui, "open");
    tooltip("Recent and built-in scenes (Ctrl+O); a scene, an environment or a measured material by its path (O)");
  }
  if (fits(button_width("Save *"))) {
    const std::string& file = ui.facts.review_file;
    if (ImGui::Button(ui.facts.review_changed ? "Save *" : "Save", {button_width("Save *"), 0.0f}))
      ui.actions.save = true;
    mark_item(ui, "save");
    tooltip(file.empty() ? "Saves the review (Ctrl+S)" : "Saves " + file + " (Ctrl+S)");
  }
  if (fits(scaled(kCameraWidth))) draw_camera_combo(ui);
  if (fits(button_width("Frame"))) {
    if (ImGui::Button("Frame")) ui.actions.frame_scene = true;
    mark_item(ui, "frame");
    tooltip("Shows the whole scene (F)");
  }
  if (fits(button_width("Dent"))) {
    const bool on = state.tool == Tool::dent;
    if (toggle_button("Dent", on)) state.tool = on ? Tool::camera : Tool::dent;
    mark_item(ui, "dent");
    tooltip("Press the mouse on a subdivision surface, such as the door, and drag down to push deeper (D)");
  }
  if (fits(button_width("Undo")))
    draw_undo(ui, "Undo", ui.facts.can_undo, &ui.actions.undo, "undo", "Takes back the last change (Ctrl+Z)");
  if (fits(button_width("Redo")))
    draw_undo(ui, "Redo", ui.facts.can_redo, &ui.actions.redo, "redo", "Makes it again (Ctrl+Y, Ctrl+Shift+Z)");
}

}  // namespace

void draw_toolbar(Ui& ui) {
  side_button(ui, false, "Materials, scene, help and review (Tab hides both sides)");
  ImGui::SameLine();
  draw_menu(ui);
  draw_open_popup(ui);
  draw_save_popup(ui);
  ImGui::SameLine();
  const float padding = ImGui::GetStyle().WindowPadding.x, width = ImGui::GetWindowWidth();
  const bool wide = width >= scaled(900.0f);
  if (wide) {
    ImGui::TextColored(kAccent, "Maquette");
    ImGui::SameLine();
  }
  const float room = wide ? scaled(296.0f) - ImGui::GetCursorPosX() : scaled(96.0f);
  ImGui::TextColored(kDim, "%s", elide(scene_title(ui.facts), room).c_str());
  if (ui.facts.scene) tooltip(ui.facts.scene->name);
  if (wide) {
    ImGui::SameLine(scaled(296.0f));
    ImGui::Dummy({padding - ImGui::GetStyle().ItemSpacing.x, 1.0f});
  }
  const float end = width - padding - ImGui::GetFrameHeight();
  draw_tools(ui, end - ImGui::GetStyle().ItemSpacing.x);
  ImGui::SameLine(end);
  side_button(ui, true, "Look, rendering, frame, error and inspection (Tab hides both sides)");
}

namespace {

std::string distance_hint(const EditorState& state) {
  const std::vector<glm::vec3>& ends = state.measured;
  if (ends.size() < 2)
    return ends.empty() ? "Distance: click on two points; Esc leaves" : "Distance: click on the other end";
  const glm::vec3 way = ends[1] - ends[0];
  char text[160];
  std::snprintf(text, sizeof text, "%.4f m   x %.4f   y %.4f   z %.4f", static_cast<double>(glm::length(way)),
                static_cast<double>(way.x), static_cast<double>(way.y), static_cast<double>(way.z));
  return text;
}

/// What is in work, how far it is, and what it will change.
std::string work_text(const EditorFacts& facts, const BackgroundWork& work) {
  char text[96];
  std::snprintf(text, sizeof text, "%s %.0f %%", work.what.c_str(), 100.0 * work.fraction);
  std::string said = text;
  if (const auto left = facts.seconds_left.find(work.what); left != facts.seconds_left.end())
    said += ", " + time_left_text(left->second);
  const std::map<std::string, BakeStatus> bakes =
      facts.stats ? facts.stats->status.bakes() : std::map<std::string, BakeStatus>();
  const auto bake = bakes.find(work.what);
  const std::string change = change_text(*facts.registry, work.what, bake != bakes.end() && bake->second.ready);
  return change.empty() ? said : said + ": it will change " + change;
}

float room_right() { return ImGui::GetWindowWidth() - ImGui::GetCursorPosX() - ImGui::GetStyle().WindowPadding.x; }

}  // namespace

void draw_status(Ui& ui) {
  char text[256];
  const EditorFacts& facts = ui.facts;
  if (facts.stats) {
    const FrameStats& stats = *facts.stats;
    std::snprintf(text, sizeof(text), "%s    %d x %d    %.1f ms    %s %d frame%s", ui.state.mode.c_str(),
                  facts.picture_px.x, facts.picture_px.y, stats.frame_ms, facts.converged ? "converged," : "average of",
                  stats.accumulated_frames, stats.accumulated_frames == 1 ? "" : "s");
    ImGui::TextUnformatted(elide(text, room_right()).c_str());
    ImGui::SameLine(0.0f, scaled(28.0f));
  }
  if (!facts.loading.empty()) {
    ImGui::TextColored(kWarning, "reading %s ...", elide(facts.loading, scaled(300.0f)).c_str());
    ImGui::SameLine(0.0f, scaled(20.0f));
  }
  for (const BackgroundWork& work : facts.background) {
    if (room_right() < scaled(kLeastWork)) break;
    const std::string said = work_text(facts, work);
    ImGui::TextColored(kWarning, "%s", elide(said, room_right()).c_str());
    mark_item(ui, "work/" + work.what);
    tooltip(said);
    ImGui::SameLine(0.0f, scaled(20.0f));
  }
  const std::string hint = ui.state.tool == Tool::dent       ? "Dent: press on a surface and drag; D leaves"
                           : ui.state.tool == Tool::region   ? "Region: drag over the picture; Esc leaves"
                           : ui.state.tool == Tool::distance ? distance_hint(ui.state)
                           : ui.state.tool == Tool::stored   ? "Stored light: click on a surface; Esc leaves"
                           : ui.state.tool == Tool::reflect  ? "Reflectors: click on panes and mirrors; Esc leaves"
                           : facts.loading.empty() && facts.background.empty() ? facts.device
                                                                               : std::string();
  const std::string shown = elide(hint, room_right());
  const float width = ImGui::CalcTextSize(shown.c_str()).x;
  ImGui::SameLine(ImGui::GetWindowWidth() - width - ImGui::GetStyle().WindowPadding.x);
  ImGui::TextColored(kDim, "%s", shown.c_str());
}

namespace {

bool in_strip(const Message& message) { return message.unread && message.level != MessageLevel::note; }

/// Errors come first, advice last, and of equal ones the latest.
int weight(const Message& message) {
  return message.level == MessageLevel::error ? 2 : message.topic.empty() && message.remedy.empty() ? 1 : 0;
}

const Message* shown_message(const EditorFacts& facts) {
  const Message* shown = nullptr;
  if (!facts.messages) return nullptr;
  for (const Message& message : *facts.messages)
    if (in_strip(message) && (!shown || weight(message) >= weight(*shown))) shown = &message;
  return shown;
}

std::size_t unread_count(const EditorFacts& facts) {
  return static_cast<std::size_t>(std::ranges::count_if(*facts.messages, in_strip));
}

float remedy_width(const Message& message) {
  if (message.remedy.empty()) return 0.0f;
  return ImGui::CalcTextSize(message.remedy.c_str()).x + scaled(20.0f);
}

}  // namespace

float strip_height(const EditorFacts& facts, float width) {
  const Message* message = shown_message(facts);
  if (!message) return 0.0f;
  const float line = ImGui::GetTextLineHeight();
  const float wrap = std::max(width - scaled(110.0f) - remedy_width(*message), scaled(80.0f));
  const float text = ImGui::CalcTextSize(message->text.c_str(), nullptr, false, wrap).y;
  const float buttons = unread_count(facts) > 1 ? line + ImGui::GetTextLineHeightWithSpacing() : line;
  return std::clamp(text, std::min(buttons, kMaxStripLines * line), kMaxStripLines * line) + scaled(18.0f);
}

void draw_strip(Ui& ui) {
  const Message* message = shown_message(ui.facts);
  if (!message) return;
  const int index = static_cast<int>(message - ui.facts.messages->data());
  const float wrap = std::max(ImGui::GetWindowWidth() - scaled(110.0f) - remedy_width(*message), scaled(80.0f));
  ImGui::PushStyleColor(ImGuiCol_Text, message->level == MessageLevel::error ? kError : kWarning);
  ImGui::SetCursorPosY(scaled(9.0f));
  ImGui::PushTextWrapPos(ImGui::GetCursorPosX() + wrap);
  ImGui::TextUnformatted(message->text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::PopStyleColor();
  tooltip(message->text);
  if (!message->remedy.empty()) {
    ImGui::SetCursorPos({ImGui::GetWindowWidth() - scaled(92.0f) - remedy_width(*message), scaled(7.0f)});
    if (ImGui::SmallButton(message->remedy.c_str())) {
      message->carry_out(&ui.state);
      ui.actions.dismiss_message = index;
    }
    mark_item(ui, "remedy");
  }
  ImGui::SetCursorPos({ImGui::GetWindowWidth() - scaled(82.0f), scaled(7.0f)});
  if (ImGui::SmallButton("Dismiss")) ui.actions.dismiss_message = index;
  mark_item(ui, "dismiss");
  const std::size_t count = unread_count(ui.facts);
  if (count < 2) return;
  ImGui::SetCursorPosX(ImGui::GetWindowWidth() - scaled(82.0f));
  if (ImGui::SmallButton(("All " + std::to_string(count)).c_str())) ui.actions.dismiss_messages = true;
  mark_item(ui, "dismiss all");
  tooltip("Dismisses the others too; the tab Frame keeps them");
}

}  // namespace maquette::panels
