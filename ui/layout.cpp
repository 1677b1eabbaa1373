#include "ui/layout.h"

#include <algorithm>
#include <cmath>

namespace maquette {

namespace {
constexpr float kToolbarHeight = 42.0f;
constexpr float kStatusHeight = 28.0f;
constexpr float kLeftWidth = 296.0f;
constexpr float kRightWidth = 328.0f;
}  // namespace

bool overlap(const Rect& a, const Rect& b) {
  if (a.empty() || b.empty()) return false;
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

std::vector<std::pair<std::string, Rect>> Layout::parts() const {
  return {{"toolbar", toolbar}, {"left", left},     {"right", right},
          {"strip", strip},     {"status", status}, {"picture", picture}};
}

Layout compute_layout(const LayoutRequest& request) {
  Layout layout;
  const float width = std::max(request.width, 1.0f), height = std::max(request.height, 1.0f);
  const auto px = [&](float units) { return std::round(units * request.scale); };
  const bool bars = !request.picture_alone && height > 3.0f * px(kToolbarHeight + kStatusHeight);
  const float top = bars ? px(kToolbarHeight) : 0.0f;
  const float bottom = bars ? px(kStatusHeight) : 0.0f;
  const auto fits = [&](float sides) { return bars && width - sides >= width / 3.0f; };
  const bool right_first = request.right_first && request.right_open && fits(px(kRightWidth));
  layout.left_shown = request.left_open && fits(px(kLeftWidth) + (right_first ? px(kRightWidth) : 0.0f));
  layout.right_shown = request.right_open && fits(px(kRightWidth) + (layout.left_shown ? px(kLeftWidth) : 0.0f));
  const float left = layout.left_shown ? px(kLeftWidth) : 0.0f;
  const float right = layout.right_shown ? px(kRightWidth) : 0.0f;
  const float middle = height - top - bottom;
  const float strip = bars ? std::min(std::ceil(request.strip_height), std::floor(middle / 3.0f)) : 0.0f;
  layout.toolbar = {0.0f, 0.0f, width, top};
  layout.status = {0.0f, height - bottom, width, bottom};
  layout.left = {0.0f, top, left, middle};
  layout.right = {width - right, top, right, middle};
  layout.strip = {left, height - bottom - strip, width - left - right, strip};
  layout.picture = {left, top, std::max(width - left - right, 1.0f), std::max(middle - strip, 1.0f)};
  return layout;
}

float fitting_scale(float wanted, float width_px, float height_px) {
  constexpr float kLeast = 0.8f;  // still legible
  constexpr float kRounding = 3.0f;
  constexpr float kWidth = 1.5f * kRightWidth + kRounding;
  constexpr float kHeight = 3.0f * (kToolbarHeight + kStatusHeight) + kRounding;
  const float most = std::min(width_px / kWidth, height_px / kHeight);
  return std::min(wanted, std::max(most, kLeast));
}

}  // namespace maquette
