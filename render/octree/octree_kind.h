#pragma once

#include <memory>
#include <string>

#include "render/bake/kept_bakes.h"
#include "render/octree/octree_build.h"

namespace maquette {

/// Everything an octree is made from, by value: the scene may change while it is built.
struct OctreeJob {
  FlatGeometry geometry;
  std::vector<int> materials;
  std::vector<bool> transmits;
  std::shared_ptr<const OctreeTextures> textures;
  OctreeOptions options;
  std::shared_ptr<const OctreeBricks> before;  ///< what may be reused; null: what the file holds
  std::string path;                            ///< of the bake file; empty: none
  std::string scene;                           ///< its name, for the file
  bool must_save = false;                      ///< a file that cannot be written is an error
  bool keeps = true;                           ///< the file is written
};

/// What the file's own materials and visible nodes give; the renderer's job differs where materials are replaced.
OctreeJob make_octree_job(const Scene& scene, const std::vector<Material>& materials, int variant, int depth);

struct OctreeResult {
  std::shared_ptr<const OctreeBricks> bricks;
  Octree octree;  ///< empty where bricks are missing
};

/// Builds, reusing what has not changed since `before` or the file, and keeps the file up to date.
class OctreeKind : public FileBakeKind<OctreeJob, OctreeResult> {
 public:
  Baked<OctreeResult> load(const OctreeJob&) override;
  Baked<OctreeResult> run(const OctreeJob&, const Baked<OctreeResult>& kept, const BakeTask<OctreeResult>&) override;

 protected:
  BakePlace place(const OctreeJob& job) const override { return {job.path, job.must_save, job.keeps}; }
  OctreeResult read(const std::string& path) const override;
  void write(const std::string& path, const OctreeJob&, const OctreeResult&, bool complete) const override;
};

/// The same on this thread. Null once `cancel` is set.
std::shared_ptr<const OctreeResult> run_octree_job(const OctreeJob& job, const std::atomic<bool>& cancel,
                                                   const std::function<void(double)>& progress);

}  // namespace maquette
