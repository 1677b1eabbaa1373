#pragma once

#include <cmath>
#include <numbers>

namespace maquette {

inline constexpr double kDegree = std::numbers::pi / 180.0;  ///< rad

/// Radians of an angle in degrees; the division comes last, so that whole parts of a turn are exact.
constexpr double radians(double degrees) { return degrees * std::numbers::pi / 180.0; }
constexpr float radians(float degrees) { return degrees * static_cast<float>(kDegree); }

/// The same direction within -180 to 180 degrees.
inline float wrap_degrees(float degrees) { return degrees - 360.0f * std::round(degrees / 360.0f); }

}  // namespace maquette
