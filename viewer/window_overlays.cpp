#include "viewer/window_overlays.h"

#include <imgui.h>

#include <cstdio>
#include <optional>

#include "render/frame/camera.h"
#include "ui/camera_control.h"

namespace maquette {

namespace {

/// Where a point is on the picture; nothing behind the eye.
std::optional<ImVec2> on_picture(const glm::mat4& clip, const glm::vec3& point, const Rect& rect) {
  const glm::vec4 p = clip * glm::vec4(point, 1.0f);
  if (p.w <= 0.0f) return std::nullopt;
  return ImVec2(rect.x + (0.5f + 0.5f * p.x / p.w) * rect.width, rect.y + (0.5f - 0.5f * p.y / p.w) * rect.height);
}

}  // namespace

void draw_distance(const EditorState& state, const Bounds& bounds, const Rect& picture) {
  if (state.tool != Tool::distance || state.measured.empty() || picture.empty()) return;
  CameraView camera = state.camera;
  fit_aspect(&camera, picture.width / picture.height);
  const glm::mat4 clip = clip_from_world(
      make_camera_frame(camera, static_cast<int>(picture.width), static_cast<int>(picture.height), bounds));
  ImDrawList* list = ImGui::GetBackgroundDrawList();
  list->PushClipRect({picture.x, picture.y}, {picture.x + picture.width, picture.y + picture.height});
  std::optional<ImVec2> ends[2];
  for (std::size_t i = 0; i < state.measured.size() && i < 2; ++i) {
    ends[i] = on_picture(clip, state.measured[i], picture);
    if (!ends[i]) continue;
    list->AddCircleFilled(*ends[i], 5.0f, IM_COL32(0, 0, 0, 160));
    list->AddCircleFilled(*ends[i], 3.5f, IM_COL32(255, 255, 255, 255));
  }
  if (ends[0] && ends[1]) {
    list->AddLine(*ends[0], *ends[1], IM_COL32(0, 0, 0, 160), 4.0f);
    list->AddLine(*ends[0], *ends[1], IM_COL32(255, 255, 255, 255), 2.0f);
    char text[48];
    std::snprintf(text, sizeof text, "%.1f mm",
                  1000.0 * static_cast<double>(glm::distance(state.measured[0], state.measured[1])));
    const ImVec2 size = ImGui::CalcTextSize(text);
    const ImVec2 at(0.5f * (ends[0]->x + ends[1]->x) + 8.0f, 0.5f * (ends[0]->y + ends[1]->y) - size.y);
    list->AddRectFilled({at.x - 4.0f, at.y - 2.0f}, {at.x + size.x + 4.0f, at.y + size.y + 2.0f},
                        IM_COL32(0, 0, 0, 170), 3.0f);
    list->AddText(at, IM_COL32(255, 255, 255, 240), text);
  }
  list->PopClipRect();
}

void draw_note(const char* text, const Rect& picture) {
  const float inset = ImGui::GetFontSize();
  ImGui::GetBackgroundDrawList()->AddText({picture.x + inset, picture.y + inset}, IM_COL32(255, 255, 255, 200), text);
}

}  // namespace maquette
