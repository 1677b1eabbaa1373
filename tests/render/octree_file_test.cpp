#include "render/octree/octree_file.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "render/octree/octree_kind.h"
#include "scenes/bake_file.h"
#include "scenes/error.h"
#include "tests/scenes/temporary_folder.h"

namespace maquette {
namespace {

OctreeJob make_job(const std::string& path) {
  const Scene scene = build_builtin_scene("seat");
  OctreeJob job;
  job.geometry = flatten(scene);
  for (const DrawItem& item : job.geometry.items) {
    job.materials.push_back(std::max(
        scene.meshes[static_cast<std::size_t>(item.mesh)].primitives[static_cast<std::size_t>(item.primitive)].material,
        0));
    job.transmits.push_back(false);
  }
  job.textures = std::make_shared<const OctreeTextures>(scene, scene.materials);
  job.options.depth = 6;
  job.path = path;
  job.scene = "builtin:seat";
  job.must_save = true;
  return job;
}

OctreeResult run(const OctreeJob& job) {
  std::atomic<bool> cancel{false};
  return *run_octree_job(job, cancel, {});
}

using OctreeFileTest = test::TemporaryFolder;

TEST_F(OctreeFileTest, RoundTrips) {
  const std::string file = path("octree.exr");
  const OctreeResult built = run(make_job(file));
  const OctreeFile loaded = load_octree_file(file);
  EXPECT_TRUE(loaded.complete);
  EXPECT_EQ(loaded.scene, "builtin:seat");
  const Octree again = assemble_octree(loaded.bricks);
  EXPECT_EQ(again.words, built.octree.words);
  EXPECT_EQ(again.colors, built.octree.colors);
  EXPECT_EQ(again.depth, built.octree.depth);
  EXPECT_EQ(again.corner, built.octree.corner);
  const OctreeResult second = run(make_job(file));
  EXPECT_EQ(second.bricks->reused, second.bricks->bricks.size());
  EXPECT_EQ(second.octree.planes, built.octree.planes);
}

TEST_F(OctreeFileTest, AnInterruptedBakeResumes) {
  const std::string file = path("octree.exr");
  OctreeJob job = make_job(file);
  std::atomic<bool> cancel{false};
  const auto stopped = run_octree_job(job, cancel, [&](double p) { cancel = cancel || p > 0.4; });
  EXPECT_FALSE(stopped);
  const OctreeFile half = load_octree_file(file);
  EXPECT_FALSE(half.complete);
  EXPECT_GT(half.bricks.bricks.size(), 0u);
  const OctreeResult rest = run(job);
  EXPECT_EQ(rest.bricks->reused, half.bricks.bricks.size());
  EXPECT_LT(rest.bricks->reused, rest.bricks->bricks.size());
  EXPECT_TRUE(load_octree_file(file).complete);
  EXPECT_EQ(rest.octree.words, run(make_job("")).octree.words);
}

TEST_F(OctreeFileTest, RefusesWhatIsDamagedOrNotAnOctree) {
  const std::string file = path("octree.exr");
  run(make_job(file));
  BakeFile bake = load_bake_file(file);
  bake.attributes["kind"] = "slf";
  save_bake_file(file, bake);
  EXPECT_THROW(load_octree_file(file), Error);
  bake.attributes["kind"] = "octree";
  bake.tables.back().integers["mask"][0] ^= 1u;
  save_bake_file(file, bake);
  EXPECT_THROW(load_octree_file(file), Error);
  const std::vector<std::uint32_t> words = run(make_job("")).octree.words;
  EXPECT_EQ(run(make_job(file)).octree.words, words) << "it is made anew";
  EXPECT_TRUE(load_octree_file(file).complete);
  std::filesystem::resize_file(file, 1000);
  EXPECT_THROW(load_octree_file(file), Error);
  EXPECT_EQ(run(make_job(file)).octree.words, words);
  EXPECT_TRUE(load_octree_file(file).complete);
}

}  // namespace
}  // namespace maquette
