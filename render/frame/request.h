#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "render/frame/camera.h"
#include "render/frame/part_mode.h"
#include "render/technique/settings.h"

namespace maquette {

/// What `reflections` says where no technique draws mirrors and glass.
inline constexpr const char *kNoReflections = "off", *kAutoReflections = "auto";  ///< auto: the exact technique

/// Everything one frame depends on besides scene, environment and materials.
struct FrameRequest {
  std::string mode = {};  ///< empty: the registry's default
  CameraView camera;
  int width = 640;
  int height = 360;
  int msaa = 1;     ///< samples a pixel: 1, 4 or 16
  int samples = 0;  ///< shading samples a pixel before prediction scales it; 0: the mode's default
  std::uint32_t seed = 0;
  float env_rotation_rad = 0.0f;
  float env_scale = 1.0f;
  int variant = -1;
  std::string reflections = kNoReflections;  ///< reflector technique
  std::vector<std::string> reflectors;       ///< nodes that reflect; empty: those that the scene marks
  /// Parts of the scene that have another shading mode than the rest; of nested ones the innermost counts.
  std::vector<PartMode> part_modes = {};
  /// Seen by an eye only, through a tone curve: what cannot be told apart may be left out (`reflections.skip`).
  bool display = false;
  /// No other frame follows: its points get rays to the sky at once, and as many as some frames of a picture at rest.
  bool single = false;
  Settings settings;
  /// Mode reference stops tracing then, within a pass if need be.
  std::optional<std::chrono::steady_clock::time_point> deadline = {};
  bool operator==(const FrameRequest&) const = default;
};

}  // namespace maquette
