#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>

#include "render/reference/light_guide.h"
#include "render/reference/path.h"
#include "render/reference/path_constants.h"
#include "render/reference/path_sharing.h"
#include "render/reference/scattering.h"

namespace maquette {

/// A shading location: the same for all paths that shade this surface until the guides are updated.
struct ShadingLocation {
  glm::vec3 position{0.0f}, error{0.0f}, normal{0.0f}, n{0.0f};  ///< of the surface point
  glm::vec3 origin{0.0f};                                        ///< origin of rays that leave the surface
  std::uint32_t cell = LightGuide::kNoCell;                      ///< of the guides
  std::uint32_t mirror_cell = 0;
  std::size_t lamp_cell = 0;  ///< of the light grid
  float lamp_rays = 0.0f;     ///< mean number of shadow rays to lamps, or kUnknown
  bool has_shares = false;
  LeafShares shares;  ///< of the guide, where has_shares
};

/// One of `rays` shadow rays of the same kind.
struct ShadowRay {
  LightDraw draw;
  float rays;
  std::uint32_t choice;  ///< index into the choices, of shadow rays to the sky
  ScatteringQuery query;
  RayPassage passage;
  glm::vec3 through{};
  bool above;  ///< above the horizon
};

/// What FullPath knows of the surface that it is at.
struct PathVertex {
  std::array<ShadingLocation, 2> locations;  ///< of the camera ray's first surface; of all others
  std::size_t location = 1;                  ///< index of the current one
  std::uint32_t shadow_rays = 0;
  PathSampler::Pairs numbers;
  std::array<EnvironmentLight::Choice, kMostShadowRays> choices;
  bool has_lamp = false;
  LightPick picked;  ///< the lamp
  std::array<ShadowRay, kMostShadowRays + 1> arriving;
  std::size_t arrived = 0;
  float mirror_share = 0.0f;  ///< of scattered rays that the guide draws
  float guided = 0.0f;        ///< probability that the guide drew the present direction
  ScatteringChoice scattering;
  DrawnDirection drawn;
  BrdfQuery query;
};

/// By what light that arrives at the current surface is multiplied.
struct PathWeight {
  glm::vec3 full{1.0f};
  glm::vec3 shared{0.0f};            ///< in the reconnection: part of `full`, without what is carried
  glm::vec3 view_independent{0.0f};  ///< 1/sr, of the second surface
};

}  // namespace maquette
