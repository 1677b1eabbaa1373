#pragma once

#include <map>
#include <string>
#include <vector>

#include "render/bake/bake.h"

namespace maquette {

/// How far a bake is.
struct BakeStatus {
  bool ready = true;
  double progress = 1.0;  ///< of the one in work, in [0, 1]
  BakeState state = BakeState::ready;
  bool wanted = false;                  ///< by this frame
  std::vector<std::string> notes = {};  ///< SceneBake::notes
};
/// Of one that a frame wants.
inline BakeStatus status_of(const Bake& bake) { return {bake.ready(), bake.progress(), bake.state(), true, {}}; }

/// What this frame can do: settings say what is wanted. A plain value; as it stands by default everything is ready and
/// the frame is the first of its picture.
struct FrameStatus {
  BakeStatus visibility, indirect, octree, cell_brdfs, shadow_rays;
  std::map<std::string, BakeStatus> own_bakes;  ///< by Technique::own_bake; one that is not listed is ready
  bool has_geometry = true;
  bool lights_count = true;   ///< what shines is bright enough to be sampled
  bool keeps_octree = false;  ///< nothing in view goes through it, but it stays for some frames more

  // Patches fitted to curved meshes, for a technique that projects into them.
  std::string fitting;       ///< names of reflectors that are left out until theirs are there
  bool all_fitting = false;  ///< of all of them
  double fit_progress = 1.0;
  std::vector<std::string> fitted;     ///< a line each: the fits that keep the tolerance
  std::vector<std::string> misfitted;  ///< those that do not

  bool single = false;  ///< no other frame follows, says the request

  // What has changed since the frame before.
  int accumulated = 0;          ///< frames in the picture so far: nothing has moved since the first of them
  bool light_rotated = false;   ///< only the environment's rotation: temporal reuse
  bool has_sun = false;         ///< the environment has one that can be drawn apart
  bool sun_apart = false;       ///< the environment has a sun, which is then drawn apart
  bool tables_swapped = false;  ///< only measured tables of materials: the points of other materials are kept

  /// Why mirrored rays are all followed; empty: those that bring little are skipped.
  std::string follows_all_rays;

  /// Those that the frame wants, by their words.
  std::map<std::string, BakeStatus> bakes() const;
};

}  // namespace maquette
