#pragma once

#include <string>

#include "render/octree/octree_build.h"

namespace maquette {

/// Writes the bricks of an octree as a bake file (multi-part EXR, docs/formats.md: tables `grid`, `bricks`, `nodes`,
/// ...). `scene` names its source; a file that is written while bricks are missing is marked as incomplete and can be
/// resumed.
void save_octree_file(const std::string& path, const OctreeBricks& bricks, const std::string& scene, bool complete);
struct OctreeFile {
  OctreeBricks bricks;
  std::string scene;
  bool complete = false;
};
/// Throws Error when the file is absent, damaged, inconsistent or not an octree.
OctreeFile load_octree_file(const std::string& path);

/// Path of a scene's octree: `folder`/octree.exr, or in the cache when `folder` is empty. Empty when there is no cache
/// either.
std::string octree_file_path(const std::string& folder, const std::string& scene, int depth);

}  // namespace maquette
