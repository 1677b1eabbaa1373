#pragma once

// Constants of full transport: probabilities and dimensions of the sampler.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace maquette {

inline constexpr int kRouletteBounce = 3;      ///< Russian roulette from this bounce on
inline constexpr float kMostSurvival = 0.95f;  ///< so that paths end even in a white furnace
/// Least probability of reflection at panes beyond the camera ray. What they reflect is found by scattered rays only,
/// and is bright when it is a lamp; what they transmit was found by shadow rays already.
inline constexpr float kLeastMirrored = 0.25f;
/// Where the guide knows mirrored lamps: share of scattered rays that it draws, and probability of reflection at panes
/// for them.
inline constexpr float kMirrorShare = 0.15f, kGuidedMirrored = 0.9f;
inline constexpr int kMostPanes = 4096;  ///< that a path passes between two surfaces
/// Shadow rays to the environment at the first surface, the second, and later ones. The light of second surfaces is
/// shared by a tile, so more rays pay off most at the first surface.
inline constexpr std::array<std::uint32_t, 3> kShadowRays{5, 3, 2};
inline constexpr std::uint32_t kMostShadowRays = *std::max_element(kShadowRays.begin(), kShadowRays.end());
/// Mean number of shadow rays to lamps at a surface: one where lamps may be brighter than the light that is known to
/// arrive from the sky; at least this many where they are dimmer.
inline constexpr float kLeastLampRays = 0.125f;
inline constexpr float kUnknown = -1.0f;
/// A surface seen in a reflection with weight w is shaded by the share kMirroredShare w of the paths: always
/// after one reflection in a pane (0.08 at normal incidence), at random after several. Random selection adds (1 / share
/// - 1) times the squared radiance of the surface to the variance, most of it of direct light, which has little noise
/// itself.
inline constexpr float kMirroredShare = 16.0f;
/// Dimensions of the sampler, for each surface and for each branch.
inline constexpr std::uint32_t kDimensionsASurface = 8;
inline constexpr std::uint32_t kDimensionsABranch = kDimensionsASurface * 256;
enum Dimension : std::uint32_t { kEnvironment, kLightChoice, kLight, kDirection, kRoulette, kPane, kChance, kGuide };

}  // namespace maquette
