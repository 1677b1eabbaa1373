#include "viewer/window_input.h"

#include <algorithm>
#include <cmath>

#include "scenes/angles.h"
#include "ui/camera_control.h"

namespace maquette {

namespace {

constexpr float kClickSlop = 4.0f;  // units that the mouse may move during a click
constexpr float kOrbitRate_rad = 0.008f;
constexpr float kLookRate_rad = 0.0035f;
constexpr float kLightRate_deg = 0.35f;
constexpr float kFastFactor = 4.0f;
constexpr float kWiperReach_px = 7.0f;  // units to each side of the line

Renderer::Pick pick_middle(const Rect& picture, const PictureInput::Pick& pick) {
  return pick(picture.x + 0.5f * picture.width, picture.y + 0.5f * picture.height);
}

/// Makes the surface in the middle of the picture the pivot of orbit and dolly.
void set_pivot(CameraView* camera, const Renderer::Pick& middle) {
  if (!middle.hit) return;
  set_target_distance(camera, glm::dot(middle.position - camera->eye, glm::normalize(camera->target - camera->eye)));
}

bool on_wiper(const ErrorView& view, const Rect& picture, float x) {
  return view.open && view.show == ErrorView::Show::wiper &&
         std::abs(x - (picture.x + view.wiper * picture.width)) <= kWiperReach_px;
}

}  // namespace

void PictureInput::handle(const PointerEvent& event, const Rect& picture, bool blocked, WindowSession* session,
                          const Pick& pick) {
  const bool inside = picture.contains(event.x, event.y) && !blocked;
  switch (event.kind) {
    case PointerEvent::Kind::press:
      if (drag_ == Drag::none && inside) press(event, picture, session, pick);
      break;
    case PointerEvent::Kind::move:
      move(event, picture, session);
      break;
    case PointerEvent::Kind::release:
      if (drag_ == Drag::none || event.button != button_) break;
      move(event, picture, session);
      if (!moved_ && drag_ == Drag::orbit && button_ == 0) click(picture, session, pick(press_x_, press_y_));
      if (drag_ == Drag::dent) session->end_dent();
      if (drag_ == Drag::region) {
        std::vector<InspectedRegion>& regions = session->state.inspection.regions;
        if (!regions.empty() && (regions.back().width == 0.0f || regions.back().height == 0.0f)) regions.pop_back();
        session->state.tool = Tool::camera;
      }
      drag_ = Drag::none;
      break;
    case PointerEvent::Kind::wheel:
      if (inside && drag_ == Drag::none) set_pivot(&session->state.camera, pick_middle(picture, pick));
      if (inside || drag_ != Drag::none) wheel(event, session);
      break;
  }
}

void PictureInput::click(const Rect& picture, WindowSession* session, const Renderer::Pick& hit) {
  const float width = std::max(picture.width, 1.0f), height = std::max(picture.height, 1.0f);
  const glm::vec2 at(2.0f * (press_x_ - picture.x) / width - 1.0f, 1.0f - 2.0f * (press_y_ - picture.y) / height);
  std::vector<glm::vec3>& ends = session->state.measured;
  if (session->state.tool == Tool::stored) {
    session->state.inspection.stored_at = glm::vec2((press_x_ - picture.x) / width, (press_y_ - picture.y) / height);
  } else if (session->state.tool == Tool::reflect) {
    session->pick_reflector(at, width / height, hit);
  } else if (session->state.tool == Tool::distance) {
    if (ends.size() >= 2) ends.clear();
    if (hit.hit) ends.push_back(hit.position);
  } else {
    session->select_in_front(at, width / height, hit);
  }
}

void PictureInput::press(const PointerEvent& event, const Rect& picture, WindowSession* session, const Pick& pick) {
  button_ = event.button;
  x_ = press_x_ = event.x;
  y_ = press_y_ = event.y;
  moved_ = false;
  EditorState& state = session->state;
  if (event.button == 1) {
    drag_ = Drag::look;
  } else if (event.button == 2 || (event.button == 0 && event.shift)) {
    drag_ = Drag::pan;
    pivot_ = pick_middle(picture, pick);
  } else if (event.button == 0 && event.ctrl) {
    drag_ = Drag::light;
  } else if (event.button == 0 && on_wiper(state.error_view, picture, event.x)) {
    drag_ = Drag::wiper;
  } else if (event.button == 0 && state.tool == Tool::region) {
    drag_ = Drag::region;
    state.inspection.regions.push_back({(event.x - picture.x) / std::max(picture.width, 1.0f),
                                        (event.y - picture.y) / std::max(picture.height, 1.0f), 0.0f, 0.0f});
    region_from_ = {state.inspection.regions.back().x, state.inspection.regions.back().y};
  } else if (event.button == 0 && state.tool == Tool::dent) {
    const Renderer::Pick hit = pick(event.x, event.y);
    if (!session->begin_dent(hit)) return;
    drag_ = Drag::dent;
    // A drag over the whole height of the picture moves the surface by half of the visible height there.
    const float visible_m = state.camera.height_at(glm::length(hit.position - state.camera.eye));
    dent_metres_per_unit_ = 0.5f * visible_m / std::max(picture.height, 1.0f);
    session->drag_dent(dent_depth(*session), state.dent_radius_m);
  } else if (event.button == 0) {
    drag_ = Drag::orbit;
    pivot_ = pick_middle(picture, pick);
  }
}

float PictureInput::dent_depth(const WindowSession& session) const {
  return session.state.dent_depth_m + (y_ - press_y_) * dent_metres_per_unit_;
}

void PictureInput::move(const PointerEvent& event, const Rect& picture, WindowSession* session) {
  if (drag_ == Drag::none) return;
  const float dx = event.x - x_, dy = event.y - y_;
  if (!moved_ && std::hypot(event.x - press_x_, event.y - press_y_) < kClickSlop) return;
  // Not at the press: a click must not change the camera, which would restart the average.
  if (!moved_ && (drag_ == Drag::orbit || drag_ == Drag::pan)) set_pivot(&session->state.camera, pivot_);
  moved_ = true;
  x_ = event.x;
  y_ = event.y;
  if (dx == 0.0f && dy == 0.0f) return;
  EditorState& state = session->state;
  switch (drag_) {
    case Drag::orbit:
      orbit(&state.camera, -dx * kOrbitRate_rad, -dy * kOrbitRate_rad);
      break;
    case Drag::look:
      look_around(&state.camera, -dx * kLookRate_rad, -dy * kLookRate_rad);
      break;
    case Drag::pan:
      pan(&state.camera, dx, dy, picture.height);
      break;
    case Drag::light:
      state.edits.env_rotation_deg = wrap_degrees(state.edits.env_rotation_deg + dx * kLightRate_deg);
      break;
    case Drag::dent:
      session->drag_dent(dent_depth(*session), state.dent_radius_m);
      break;
    case Drag::wiper:
      state.error_view.wiper = std::clamp((event.x - picture.x) / std::max(picture.width, 1.0f), 0.0f, 1.0f);
      break;
    case Drag::region:
      drag_region(event, picture, &state.inspection.regions.back());
      break;
    case Drag::none:
      break;
  }
}

void PictureInput::drag_region(const PointerEvent& event, const Rect& picture, InspectedRegion* region) const {
  const float x = std::clamp((event.x - picture.x) / std::max(picture.width, 1.0f), 0.0f, 1.0f);
  const float y = std::clamp((event.y - picture.y) / std::max(picture.height, 1.0f), 0.0f, 1.0f);
  *region = {std::min(x, region_from_.x), std::min(y, region_from_.y), std::abs(x - region_from_.x),
             std::abs(y - region_from_.y)};
}

void PictureInput::wheel(const PointerEvent& event, WindowSession* session) {
  EditorState& state = session->state;
  if (drag_ == Drag::dent) {
    state.dent_radius_m = std::clamp(state.dent_radius_m * std::pow(1.1f, event.wheel), 0.01f, 2.0f);
    session->drag_dent(dent_depth(*session), state.dent_radius_m);
  } else if (drag_ == Drag::look) {
    state.fly_speed = std::clamp(state.fly_speed * std::pow(1.2f, event.wheel), 0.005f, 20.0f);
  } else {
    dolly(&state.camera, event.wheel);
  }
}

void PictureInput::fly(const glm::vec3& direction, bool fast, float seconds, WindowSession* session) {
  if (drag_ != Drag::look || glm::dot(direction, direction) == 0.0f) return;
  moved_ = true;
  const float radius = std::max(session->scene_radius(), 1e-6f);
  const float speed = session->state.fly_speed * radius * (fast ? kFastFactor : 1.0f);
  maquette::fly(&session->state.camera, glm::normalize(direction) * (speed * std::min(seconds, 0.1f)));
}

}  // namespace maquette
