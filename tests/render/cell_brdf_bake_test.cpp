#include "render/octree/cell_brdf_bake.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "render/octree/cell_brdf_kind.h"
#include "render/octree/octree_interest.h"
#include "scenes/bake_file.h"
#include "scenes/error.h"
#include "tests/scenes/temporary_folder.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

using test::add;
using test::make_grid;
using test::matte;

/// Two floors, each with a post: one of materials 0 and 1, the other of 0 and 2, too far apart to share a brick.
Scene two_places() {
  Scene scene;
  scene.materials = {matte(glm::vec3(0.5f)), matte({0.8f, 0.1f, 0.1f}), matte({0.1f, 0.1f, 0.8f})};
  for (int k = 0; k < 2; ++k) {
    const float x = k == 0 ? -1.0f : 1.0f;
    const std::string name = k == 0 ? "left" : "right";
    add(&scene, make_grid({x - 0.3f, 0.0f, 0.3f}, {0.6f, 0, 0}, {0, 0, -0.6f}, 6, 0), name);
    add(&scene, make_grid({x, 0.0f, -0.2f}, {0, 0, 0.4f}, {0, 0.3f, 0}, 4, k + 1), name + " post");
  }
  return scene;
}

CellBrdfJob job_of(const Scene& scene, const std::string& path) {
  CellBrdfJob job;
  job.octree = make_octree_job(scene, scene.materials, -1, 5);
  job.octree.options.detail = 0;  // as always when cells have BRDFs
  job.octree.path = path;
  job.octree.must_save = true;
  job.materials = scene.materials;
  job.options = {.clusters = 4, .components = 4, .training = 60, .samples = 16};
  std::atomic<bool> cancel{false};
  job.bricks = run_octree_job(job.octree, cancel, {})->bricks;
  return job;
}

CellBrdfs run(const CellBrdfJob& job) {
  std::atomic<bool> cancel{false};
  return *run_cell_brdf_job(job, cancel, {});
}

using CellBrdfBake = test::TemporaryFolder;

TEST_F(CellBrdfBake, FlatCellsOfOneMaterialShareAndOthersHaveTheirOwn) {
  const CellBrdfs brdfs = run(job_of(two_places(), ""));
  EXPECT_GT(brdfs.shared_count(), 0u);
  EXPECT_LT(brdfs.shared_count(), brdfs.cell_count());
  // One for the floor's colour and one for each post: far fewer vectors than cells.
  EXPECT_EQ(brdfs.baked_cells, brdfs.cell_count() - brdfs.shared_count() + 3);
  EXPECT_LT(std::sqrt(brdfs.light_error / brdfs.light_energy), 0.25);
  EXPECT_LT(std::sqrt(brdfs.area_error / brdfs.area_energy), 0.15);
}

TEST_F(CellBrdfBake, ANewMaterialBakesOnlyItsBricks) {
  Scene scene = two_places();
  const CellBrdfJob first = job_of(scene, "");
  const CellBrdfs before = run(first);
  scene.materials[2].base_color = glm::vec4(0.08f, 0.08f, 0.6f, 1.0f);
  CellBrdfJob job = first;
  job.octree.before = first.bricks;
  std::atomic<bool> cancel{false};
  const auto octree = run_octree_job(job.octree, cancel, {});
  EXPECT_EQ(octree->bricks->reused, octree->bricks->bricks.size());
  job.materials = scene.materials;
  job.before = std::make_shared<const CellBrdfs>(before);
  const CellBrdfs after = run(job);
  EXPECT_GT(after.reused, 0u);
  EXPECT_LT(after.reused, after.bricks.size());
  EXPECT_GT(after.baked_cells, 0u);
  EXPECT_LT(after.baked_cells, before.baked_cells);
  for (const auto& [code, brick] : after.bricks) {
    const bool same = brick.key == before.bricks.at(code).key;
    EXPECT_EQ(brick.nodes, before.bricks.at(code).nodes);
    if (same) {
      EXPECT_EQ(brick.codes, before.bricks.at(code).codes);
    }
  }
}

TEST_F(CellBrdfBake, AnInterruptedBakeResumes) {
  const std::string file = path("octree.exr");
  const CellBrdfJob job = job_of(two_places(), file);
  std::atomic<bool> cancel{false};
  EXPECT_FALSE(run_cell_brdf_job(job, cancel, [&](double p) { cancel = cancel || p > 0.7; }));
  const CellBrdfFile half = load_cell_brdf_file(cell_brdf_file_path(file));
  EXPECT_FALSE(half.complete);
  EXPECT_GT(half.brdfs.bricks.size(), 0u);
  const CellBrdfs rest = run(job);
  EXPECT_EQ(rest.reused, half.brdfs.bricks.size());
  EXPECT_LT(rest.reused, rest.bricks.size());
  const CellBrdfFile whole = load_cell_brdf_file(cell_brdf_file_path(file));
  EXPECT_TRUE(whole.complete);
  EXPECT_EQ(whole.brdfs.cell_count(), rest.cell_count());
  EXPECT_EQ(run(job).reused, rest.bricks.size());
  // Before the compression is written, nothing is kept, and nothing fails.
  std::filesystem::remove(cell_brdf_file_path(file));
  cancel = true;
  EXPECT_FALSE(run_cell_brdf_job(job, cancel, {}));
  EXPECT_EQ(run(job).cell_count(), rest.cell_count());
}

TEST_F(CellBrdfBake, DamagedFilesAreMadeAnew) {
  const std::string file = path("octree.exr"), brdf_file = cell_brdf_file_path(file);
  const CellBrdfJob job = job_of(two_places(), file);
  run(job);
  BakeFile bake = load_bake_file(brdf_file);
  bake.tables[3].integers["code"][0] = 100000u;
  save_bake_file(brdf_file, bake);
  EXPECT_THROW(load_cell_brdf_file(brdf_file), Error);
  EXPECT_GT(run(job).baked_cells, 0u);
  EXPECT_NO_THROW(load_cell_brdf_file(brdf_file));
  bake.attributes["kind"] = "octree";
  save_bake_file(brdf_file, bake);
  EXPECT_THROW(load_cell_brdf_file(brdf_file), Error);
  std::filesystem::resize_file(brdf_file, 3000);
  EXPECT_THROW(load_cell_brdf_file(brdf_file), Error);
}

TEST_F(CellBrdfBake, AScreenThatGlowsKeepsItsMaterial) {
  Scene scene = two_places();
  const std::size_t all = run(job_of(scene, "")).cell_count();
  scene.materials[2].emissive = glm::vec3(5.0f);
  EXPECT_LT(run(job_of(scene, "")).cell_count(), all);
}

TEST(OctreeInterest, NamesNodesAndBoxes) {
  const Scene scene = two_places();
  const FlatGeometry geometry = flatten(scene);
  EXPECT_TRUE(find_interest("", scene, geometry).empty());
  const auto boxes = find_interest(" left post ; 0,1,2, 3,4,5", scene, geometry);
  ASSERT_EQ(boxes.size(), 2u);
  EXPECT_NEAR(boxes[0].max.y, 0.3f, 1e-6f);
  EXPECT_NEAR(boxes[0].min.x, -1.0f, 1e-6f);
  EXPECT_EQ(boxes[1].max, glm::vec3(3.0f, 4.0f, 5.0f));
  for (const char* wrong : {"left posts", "1,2,3", "1,2,3,0,4,5", "0,0,0,1,1,inf"})
    EXPECT_THROW(find_interest(wrong, scene, geometry), UsageError) << wrong;
}

/// A seat that moves rebuilds the bricks that it leaves and enters, and no others.
TEST(OctreeBuild, AMovedPartRebuildsWhereItWasAndIs) {
  const Scene scene = two_places();
  OctreeJob job = make_octree_job(scene, scene.materials, -1, 6);
  std::atomic<bool> cancel{false};
  job.before = run_octree_job(job, cancel, {})->bricks;
  const auto& item = job.geometry.items[3];  // the right post
  for (std::uint32_t v = item.first_vertex; v < item.first_vertex + item.vertex_count; ++v)
    job.geometry.positions[v].x += 0.1f;
  const auto moved = run_octree_job(job, cancel, {})->bricks;
  std::size_t left = 0;
  for (const auto& [code, entry] : moved->bricks) {
    const auto old = job.before->bricks.find(code);
    const bool same = old != job.before->bricks.end() && old->second.key == entry.key;
    const float x = static_cast<float>(moved->grid.corner.x) +
                    static_cast<float>(moved->grid.side_m) / 16.0f *
                        static_cast<float>((code & 1u) | (code >> 2 & 2u) | (code >> 4 & 4u) | (code >> 6 & 8u));
    if (x >= 0.5f) continue;
    EXPECT_TRUE(same);
    ++left;
  }
  EXPECT_GT(left, 0u);
  EXPECT_GE(moved->reused, left);
  EXPECT_LT(moved->reused, moved->bricks.size());
}

}  // namespace
}  // namespace maquette
