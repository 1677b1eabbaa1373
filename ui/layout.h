#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

namespace maquette {

/// In ImGui units (window coordinates), y down.
struct Rect {
  float x = 0.0f, y = 0.0f, width = 0.0f, height = 0.0f;
  bool empty() const { return width <= 0.0f || height <= 0.0f; }
  bool contains(float px, float py) const { return px >= x && py >= y && px < x + width && py < y + height; }
};
bool overlap(const Rect& a, const Rect& b);

/// Positions of the parts of the window: fixed, side by side, without overlap.
struct Layout {
  Rect toolbar, left, right, strip, status, picture;
  bool left_shown = false, right_shown = false;
  std::vector<std::pair<std::string, Rect>> parts() const;
};

struct LayoutRequest {
  float width = 1280.0f, height = 720.0f;
  float scale = 1.0f;  ///< of the font, with the display's content scale
  bool left_open = true, right_open = true;
  float strip_height = 0.0f;  ///< of unread messages, 0: none
  bool picture_alone = false;
  bool right_first = false;  ///< the left side gives way before the right one
};
/// The side panels give way (right first, unless asked otherwise) when the picture would get narrower than a third of
/// the window. The picture is at least 1 x 1.
Layout compute_layout(const LayoutRequest& request);

/// The scale of text and controls that is nearest to `wanted`, at which a window of so many pixels has room for the
/// bars and one side panel.
float fitting_scale(float wanted, float width_px, float height_px);

}  // namespace maquette
