#pragma once

#include <cstdint>

#include "render/frame/key.h"

namespace maquette {

/// A revision of each thing that results may depend on: it grows with every change of that thing.
struct Revisions {
  std::uint32_t geometry = 0;   ///< positions and normals
  std::uint32_t occlusion = 0;  ///< what may hide something: geometry, and which nodes are shown
  std::uint32_t surfaces = 0;   ///< what the G-buffer holds: geometry, what is shown, materials but for measured tables
  std::uint32_t tables = 0;     ///< measured tables of materials
  std::uint32_t lights = 0;     ///< what shines besides the sky
  std::uint32_t sky = 0;        ///< the environment, but for its rotation and scale
  bool operator==(const Revisions&) const = default;

  /// All that the radiance of a point depends on besides its own material's table.
  Key without_tables() const { return Key::of(geometry, occlusion, surfaces, lights, sky); }
  Key all() const { return Key::of(without_tables(), tables); }
  /// What colours or emits light on surfaces, whatever the sky is: of indirect light.
  Key bounces() const { return Key::of(geometry, occlusion, surfaces, lights, tables); }
};

}  // namespace maquette
