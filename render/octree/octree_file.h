#pragma once

#include <string>

#include "render/octree/octree_build.h"

namespace maquette {

/// The bricks of an octree as a bake file (multi-part EXR, docs/formats.md: tables `grid`, `bricks`, `nodes`, ...).
/// `scene` names what it was made from; a file written while bricks are missing says so and serves to resume.
void save_octree_file(const std::string& path, const OctreeBricks& bricks, const std::string& scene, bool complete);
struct OctreeFile {
  OctreeBricks bricks;
  std::string scene;
  bool complete = false;
};
/// Throws Error: absent, damaged, not an octree, or inconsistent.
OctreeFile load_octree_file(const std::string& path);

/// Where the octree of a scene is kept: `folder`/octree.exr, or the cache when `folder` is empty. Empty: nowhere.
std::string octree_file_path(const std::string& folder, const std::string& scene, int depth);

}  // namespace maquette
