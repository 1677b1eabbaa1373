#pragma once

#include "scenes/environment.h"
#include "scenes/scene.h"

namespace maquette {

/// Whether something level lies below the scene: surfaces that face up or down at its lowest 2 % and cover at least
/// half of its floor plan. True for a scene without surfaces.
bool has_ground(const Scene& scene);

/// A ground on which the environment is projected.
struct GroundOptions {
  float height_m = 1.6f;   ///< of the point from which the environment was photographed, above the ground
  float roughness = 1.0f;  ///< 1: matte, without gloss; below, a gloss of a dielectric
};

/// Adds a disc below the scene, node and material "Ground", that shows the lower half of the environment as seen from
/// `height_m` above it: its base colour is the one with which light from the whole upper half makes it as bright as the
/// environment is there, so that it goes over into it without a seam and gets darker only where something stands in the
/// light. What would have to reflect more than all is as bright as a white one. The environment's rotation is an offset
/// of its texture (ground_texture_offset). Does nothing for a scene without surfaces.
void add_ground(Scene* scene, const Environment& environment, const GroundOptions& options);
/// Takes away what add_ground() has added last.
void remove_ground(Scene* scene);
/// Of the ground's textures, for an environment that is turned by so much about +Y.
glm::vec2 ground_texture_offset(float env_rotation_rad);
/// Irradiance of a level surface by the upper half of an environment, lux per channel.
glm::dvec3 upper_irradiance(const Environment& environment);

inline constexpr const char* kGroundName = "Ground";
/// Whether this node is one that add_ground() made.
bool is_added_ground(const Scene& scene, std::size_t node);

}  // namespace maquette
