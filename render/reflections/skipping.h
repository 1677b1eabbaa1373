#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/gl/objects.h"
#include "render/reference/shared_formulas.h"
#include "render/reflections/mirrored_bound.h"

namespace maquette {

/// All that the light in a bound depends on.
struct SkipLightKey {
  std::uint32_t epoch = 0;
  float rotation_rad = 0.0f, scale = 0.0f;
  bool shadows = false;
  bool operator==(const SkipLightKey&) const = default;
};

/// Which mirrored rays need not be followed: what is known from frame to frame.
struct Skipping {
  MirroredBound bound;
  std::optional<std::uint32_t> geometry_epoch;  ///< of `bound`
  std::uint32_t seen_epoch = 0;                 ///< of the frame before: while geometry changes nothing is skipped
  std::vector<std::size_t> items;               ///< of the reflectors
  std::vector<bool> occluding;
  std::optional<SkipLightKey> light;
  std::shared_ptr<const Environment> environment;
  SkyBound sky;  ///< of it
  struct Lobe {
    shared::AnalyticMaterial material;
    LobeBound bound;
  };
  std::vector<Lobe> lobes;                   ///< of analytic materials met so far
  std::optional<glm::mat4> clip_from_world;  ///< that the bounds on the GPU are for
  Buffer parts, bounds, counters;
  Texture part_view, bound_view, cover;
  GlName<FramebufferTraits> framebuffer;
  std::size_t bytes() const { return parts.bytes() + bounds.bytes() + counters.bytes() + cover.bytes(); }
};

}  // namespace maquette
