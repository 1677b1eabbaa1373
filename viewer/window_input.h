#pragma once

#include <functional>
#include <glm/glm.hpp>

#include "ui/editor.h"
#include "viewer/window_session.h"

namespace maquette {

/// A mouse event in window coordinates. Several, in order, may belong to one frame.
struct PointerEvent {
  enum class Kind { press, release, move, wheel };
  Kind kind = Kind::move;
  int button = 0;  ///< 0 left, 1 right, 2 middle
  float x = 0.0f, y = 0.0f;
  float wheel = 0.0f;
  bool shift = false, ctrl = false;  ///< of presses
};

/// Handles the mouse over the picture: cameras, light, selection, dents, the wiper.
class PictureInput {
 public:
  /// `pick`: what is at a point of the picture rectangle.
  using Pick = std::function<Renderer::Pick(float x, float y)>;

  /// `blocked`: a popup is open, presses are not for the picture.
  void handle(const PointerEvent& event, const Rect& picture, bool blocked, WindowSession* session, const Pick& pick);
  /// Flies while the right button is held; `direction` of the keys held, x right, y up, z forward.
  void fly(const glm::vec3& direction, bool fast, float seconds, WindowSession* session);
  bool dragging() const { return drag_ != Drag::none; }

 private:
  enum class Drag { none, orbit, pan, look, light, dent, wiper, region };
  void click(const Rect& picture, WindowSession* session, const Renderer::Pick& hit);
  void press(const PointerEvent& event, const Rect& picture, WindowSession* session, const Pick& pick);
  void move(const PointerEvent& event, const Rect& picture, WindowSession* session);
  void wheel(const PointerEvent& event, WindowSession* session);
  float dent_depth(const WindowSession& session) const;
  void drag_region(const PointerEvent& event, const Rect& picture, InspectedRegion* region) const;

  Drag drag_ = Drag::none;
  int button_ = 0;
  float x_ = 0.0f, y_ = 0.0f, press_x_ = 0.0f, press_y_ = 0.0f;
  bool moved_ = false;
  Renderer::Pick pivot_;
  float dent_metres_per_unit_ = 0.0f;
  glm::vec2 region_from_{0.0f};
};

}  // namespace maquette
