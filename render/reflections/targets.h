#pragma once

#include <cstddef>

#include "render/gbuffer/tiles.h"
#include "render/gl/objects.h"

namespace maquette {

/// Images of the reflections, at a fraction of the shading grid: first the panes, then the hits of their mirrored rays,
/// which are shaded like any other G-buffer. One layer: the nearest reflector of each pixel.
struct ReflectionTargets {
  int width = 0, height = 0;
  int divisor = 1;  ///< of the shading grid
  TileList tiles;   ///< tiles of one band that have rays
  GlName<FramebufferTraits> pane_framebuffer;
  Texture pane;        ///< RG32UI: triangle + 1, reflector + 1; 0 where no reflector is visible
  Texture pane_depth;  ///< depth buffer of the panes
  Texture ray_origin;  ///< RGBA32F: point of the pane, m; w: its depth along the viewing axis, 0 without reflector
  /// RGBA32F: mirrored ray, unit; w: reflector + 1, negated where it is not traced: `ray_origin` then holds the
  /// radiance to show, cd/m2
  Texture ray_direction;
  Texture triangle;  ///< R32UI: hit of the ray, triangle + 1; 0: none. Written by the technique.
  Texture effort;    ///< RG8UI, for debug views: steps of the search; level of the octree, or root of the cubic
  Texture layers;  ///< RG32UI, octree cells with BRDFs: first layer, their count and the transmittance; made on demand
  Texture focus;   ///< R16F, 1/m: the mirrored ray of a patch meets a caustic at its reciprocal; 0: never. Of a glossy
                   ///< surface, rad: half of its lobe lies within
  Texture low_confidence;         ///< R8UI: 1 where the result of the technique is uncertain; cleared before it runs
  Texture surface, depth, guide;  ///< of the hit, as in the frame's G-buffer; depth: m along the ray
  Texture details;                ///< of the hit, as in the frame's G-buffer; made on demand
  Texture layer_depth;            ///< depth where the hit is of one layer, 0 elsewhere; made on demand
  Texture marks, radiance;        ///< radiance.w: 0 where the ray leaves the scene
  Texture tint;                   ///< RGBA16, share of the hit's light that panes on the way leave; made on demand
  Texture mean;                   ///< RGBA32F, the radiance averaged over frames at rest; made on demand
};

ReflectionTargets make_reflection_targets(int grid_width, int grid_height, int divisor);
std::size_t reflection_bytes(const ReflectionTargets& targets);

}  // namespace maquette
