#pragma once

#include <glm/glm.hpp>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "render/frame/camera.h"
#include "render/frame/request.h"
#include "render/technique/registry.h"
#include "render/technique/settings.h"

namespace maquette {

/// A dent in subdivision surfaces, `--dent x,y,z,depth,radius` in metres (world space): pressed against the normal of
/// the surface that is nearest, as the dents before it have left it.
struct Dent {
  glm::vec3 center{0.0f};
  float depth_m = 0.0f;  ///< negative pulls out
  float radius_m = 0.0f;
  std::string part = {};  ///< path of the only node whose surface moves; empty: all that are near enough
  bool operator==(const Dent&) const = default;
};

/// A node turned with what is below it, `--turn NODE=x,y,z,DEG`.
struct NodeTurn {
  std::string node;                  ///< its name or path, or `*`: all that is drawn, about the origin of the world
  glm::vec3 axis{0.0f, 1.0f, 0.0f};  ///< unit, in the frame of the node's parent, through the node's origin
  float angle_deg = 0.0f;
  bool operator==(const NodeTurn&) const = default;
};

/// A moment of one of the scene's animations.
struct PlayedAnimation {
  std::string name;  ///< empty: the scene rests as the file has it
  double time_s = 0.0;
  bool operator==(const PlayedAnimation&) const = default;
};

/// What is changed of the scene and its light. Nodes are named by their paths (scenes/node_paths.h).
struct Edits {
  std::string environment = "builtin:clear-sky";
  float env_rotation_deg = 0.0f;
  float env_scale = 1.0f;                        ///< cd/m2 per stored unit
  std::string variant;                           ///< empty: as in the file
  std::map<std::string, std::string> materials;  ///< material name -> source; absent: as in the file
  std::vector<Dent> dents;                       ///< in the order in which they were pressed
  PlayedAnimation animation;                     ///< moves nodes; dents follow them
  std::vector<NodeTurn> turns;                   ///< on top of it, one after the other
  std::set<std::string> hidden_nodes;
  std::set<std::string> reflectors;  ///< paths or names of nodes; empty: those that the scene marks
  /// Section plane, as CameraView has it: what is seen, m; 0: none.
  glm::vec4 section{0.0f};
  std::map<std::string, std::string> part_modes;  ///< path of a node -> shading mode of it and of what is below it
  bool operator==(const Edits&) const = default;
};

/// One state of a scene: all that decides what a picture of it shows, but not its size and sampling. A plain value:
/// command line, panels, undo, review file and playback make and change it.
struct Look {
  std::string name, note;
  Edits edits;
  CameraView camera;
  std::string mode = builtin_registry().default_mode;
  std::string reflections = kAutoReflections;  ///< reflector technique
  Settings settings;
  float exposure_ev = 0.0f;
  bool auto_exposure = true;  ///< metered: then `exposure_ev` is what was found last, and no part of the look
  std::string tonemap = "pbr-neutral";
  bool operator==(const Look&) const = default;
};

/// Without what is only found: the exposure of a look that is metered.
inline Look canonical(Look look) {
  if (look.auto_exposure) look.exposure_ev = 0.0f;
  return look;
}

}  // namespace maquette
