// The keys of a camera path along their time, to be dragged.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "ui/widgets.h"

namespace maquette::panels {

namespace {

/// The bar without its keys: seconds, and the time that is shown.
void draw_bar(const ImVec2& at, float width, float height, float end_s, float shown_s) {
  ImDrawList* list = ImGui::GetWindowDrawList();
  list->AddRectFilled(at, {at.x + width, at.y + height}, ImGui::GetColorU32(ImGuiCol_FrameBg), scaled(2.0f));
  constexpr float kMostTicks = 40.0f;
  const float step_s = end_s <= kMostTicks ? 1.0f : 10.0f;
  for (float t = step_s; t < end_s && end_s / step_s <= 2.0f * kMostTicks; t += step_s) {
    const float x = at.x + t / end_s * width;
    list->AddLine({x, at.y + 0.7f * height}, {x, at.y + height}, ImGui::GetColorU32(kDim));
  }
  const float x = at.x + std::clamp(shown_s / end_s, 0.0f, 1.0f) * width;
  list->AddLine({x, at.y}, {x, at.y + height}, ImGui::GetColorU32(ImGuiCol_Text), scaled(1.0f));
}

void draw_diamond(const ImVec2& middle, float half, bool chosen, bool skipped) {
  ImDrawList* list = ImGui::GetWindowDrawList();
  const ImU32 color = ImGui::GetColorU32(chosen ? kAccent : skipped ? kDim : ImVec4(0.85f, 0.85f, 0.87f, 1.0f));
  const ImVec2 top(middle.x, middle.y - half), right(middle.x + half, middle.y), low(middle.x, middle.y + half),
      left(middle.x - half, middle.y);
  if (skipped)
    list->AddQuad(top, right, low, left, color);
  else
    list->AddQuadFilled(top, right, low, left, color);
}

/// From where the button was pressed to where the mouse is now.
bool was_dragged() {
  const ImGuiIO& io = ImGui::GetIO();
  const ImVec2 begin = io.MouseClickedPos[ImGuiMouseButton_Left];
  return std::hypot(io.MousePos.x - begin.x, io.MousePos.y - begin.y) >= io.MouseDragThreshold;
}

}  // namespace

void draw_timeline(Ui& ui, CameraPath* path) {
  PathView& view = ui.state.path_view;
  const float half = scaled(5.0f), height = scaled(18.0f);
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const ImVec2 at(corner.x + half, corner.y);
  const float width = std::max(ImGui::GetContentRegionAvail().x - 2.0f * half, 1.0f);
  // While a key is dragged the scale stays, even where the path gets longer.
  float* held_s = ImGui::GetStateStorage()->GetFloatRef(ImGui::GetID("held end"), 0.0f);
  const float end_s = *held_s > 0.0f ? *held_s : std::max(static_cast<float>(path_duration_s(*path)), 0.1f);
  draw_bar(at, width, height, end_s, static_cast<float>(view.time_s));
  const std::vector<double> times = key_times_s(*path);
  bool dragging = false;
  for (std::size_t i = 0; i < path->keys.size(); ++i) {
    const float x = at.x + std::clamp(static_cast<float>(times[i]) / end_s, 0.0f, 1.0f) * width;
    ImGui::PushID(static_cast<int>(i));
    ImGui::SetCursorScreenPos({x - half, at.y});
    ImGui::InvisibleButton("key", {2.0f * half, height});
    if (ImGui::IsItemActivated()) view.key = static_cast<int>(i);
    // In a slow frame the last way and the release come together.
    const bool released = ImGui::IsItemDeactivated() && ImGui::IsMouseReleased(ImGuiMouseButton_Left);
    if (ImGui::IsItemActive() || released) {
      dragging = !released;
      if (ImGui::IsMouseDragging(ImGuiMouseButton_Left) || (released && was_dragged()))
        move_key(path, i, static_cast<double>((ImGui::GetIO().MousePos.x - at.x) / width * end_s));
      view.time_s = key_times_s(*path)[i];
      view.goes_there = true;
    }
    draw_diamond({x, at.y + 0.5f * height}, half, view.key == static_cast<int>(i), path->keys[i].skip);
    mark_item(ui, "timeline/" + std::to_string(i + 1));
    char text[160];
    std::snprintf(text, sizeof text, "%s, %.2f s\nDrag it to another time; the keys beside it stay",
                  path->keys[i].name.empty() ? ("key " + std::to_string(i + 1)).c_str() : path->keys[i].name.c_str(),
                  times[i]);
    tooltip(text);
    ImGui::PopID();
  }
  *held_s = dragging ? end_s : 0.0f;
  ImGui::SetCursorScreenPos(corner);
  ImGui::Dummy({width + 2.0f * half, height});
}

}  // namespace maquette::panels
