#include "render/prt/transfer_bake.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <filesystem>
#include <fstream>
#include <glm/gtc/matrix_transform.hpp>
#include <thread>

#include "render/prt/job.h"
#include "render/prt/transfer_files.h"
#include "scenes/bake_file.h"
#include "scenes/btf/btf_file.h"
#include "scenes/btf/half_floats.h"
#include "scenes/error.h"
#include "scenes/ground.h"
#include "scenes/srgb.h"
#include "tests/scenes/temporary_folder.h"
#include "tests/support/never.h"
#include "tests/support/small_btf.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

/// A plate below a block; the block casts shadows on it.
Scene plate_and_block() {
  Scene scene;
  scene.name = "plate-and-block";
  scene.materials.push_back(test::matte(glm::vec3(0.5f)));
  test::add(&scene, test::make_grid({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 5, 0), "plate");
  test::add(&scene, test::make_grid({-0.5f, 0.3f, 0.2f}, {0.8f, 0, 0}, {0, 0.5f, 0}, 1, 0), "block");
  return scene;
}

void turn(Scene* scene, std::size_t node, double degrees) {
  scene->nodes[node].local =
      glm::mat4(glm::rotate(glm::dmat4(1.0), glm::radians(degrees), glm::dvec3(0.3, 0.8, -0.5))) *
      scene->nodes[node].local;
}

TransferJob job_of(const Scene& scene, const std::string& folder) {
  TransferJob job;
  job.scene = scene.name;
  job.geometry = std::make_shared<const FlatGeometry>(flatten(scene));
  job.parts = {{.item = 0}};
  job.materials = {test::small_btf(2, 2)};
  job.occluding.assign(job.geometry->items.size(), true);
  job.options = {.faces = 4, .rays = 1, .clusters = 3, .components = 2, .btf_components = 2};
  job.folder = folder;
  job.must_work = !folder.empty();
  return job;
}

/// All that is drawn with.
std::vector<std::uint16_t> content(const Transfer& transfer) {
  std::vector<std::uint16_t> all;
  for (const TransferGroup& group : transfer.bake->groups)
    for (const TransferMatrix& m : group.matrices) {
      all.insert(all.end(), m.owner.begin(), m.owner.end());
      all.insert(all.end(), m.weights.begin(), m.weights.end());
    }
  CubeLight light = CubeLight::Ones(96, 3);
  for (Eigen::Index i = 0; i < 96; ++i) light(i, 0) = static_cast<float>(i % 7);
  std::vector<glm::vec4> sums;
  transfer.bake->table.sums(choose_coefficients(light, transfer.bake->table.importance(), 96), &sums);
  for (const glm::vec4& s : sums)
    for (int c = 0; c < 3; ++c) all.push_back(half_of_float(s[c]));
  return all;
}

std::string message(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

class TransferBakeTest : public maquette::test::TemporaryFolder {};

TEST_F(TransferBakeTest, IsTheSameForAnyThreadsRanksAndInterruptions) {
  const Scene scene = plate_and_block();
  const auto whole = bake_transfer(job_of(scene, {}), {}, nullptr, kNever, {});
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->bake->blocks, 1u + 19u);
  EXPECT_EQ(whole->bake->groups[0].matrices.size(), 1u + 2u * 19u);
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(content(*bake_transfer(job_of(scene, {}), {}, nullptr, kNever, {})), content(*whole));
  }
  // Stopped after five blocks, then resumed.
  std::atomic<bool> cancel{false};
  const TransferJob job = job_of(scene, path("resumed"));
  EXPECT_EQ(bake_transfer(job, {}, nullptr, cancel,
                          [&](double share) {
                            if (share >= 0.25) cancel = true;
                          }),
            nullptr);
  const TransferSummary summary = summarize_transfer(job.folder);
  EXPECT_EQ(summary.blocks, 20u);
  EXPECT_EQ(summary.blocks_done, 5u);
  const auto resumed = bake_transfer(job, {}, nullptr, kNever, {});
  EXPECT_EQ(resumed->bake->reused, 5u);
  EXPECT_EQ(content(*resumed), content(*whole));
  // Two processes share the work.
  std::shared_ptr<const Transfer> other;
  std::thread second([&] { other = bake_transfer(job_of(scene, path("shared")), {1, 2}, nullptr, kNever, {}); });
  const auto first = bake_transfer(job_of(scene, path("shared")), {0, 2}, nullptr, kNever, {});
  second.join();
  EXPECT_EQ(content(*first), content(*whole));
  EXPECT_EQ(content(*other), content(*whole));
}

TEST_F(TransferBakeTest, JointFormAndReflectionsAreTheSameForAnyThreadsRanksAndInterruptions) {
  const auto job = [&](const std::string& folder) {
    TransferJob j = job_of(plate_and_block(), folder);
    j.parts.push_back({.item = 1});
    j.options.joint = true;
    j.options.texel_clusters = 2;
    j.options.joint_clusters = 3;
    j.options.bounces = 2;
    return j;
  };
  const auto whole = bake_transfer(job({}), {}, nullptr, kNever, {});
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->bake->blocks, 2u * 3u);
  EXPECT_EQ(whole->bake->groups[0].matrices.size(), 6u * 19u);
  EXPECT_EQ(whole->bake->bytes_per_vertex(whole->bake->groups[0]), 6u * 3u * 2u);
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(content(*bake_transfer(job({}), {}, nullptr, kNever, {})), content(*whole));
  }
  std::atomic<bool> cancel{false};
  EXPECT_EQ(bake_transfer(job(path("resumed")), {}, nullptr, cancel,
                          [&](double share) {
                            if (share >= 0.5) cancel = true;
                          }),
            nullptr);
  const auto resumed = bake_transfer(job(path("resumed")), {}, nullptr, kNever, {});
  EXPECT_EQ(resumed->bake->reused, 3u);
  EXPECT_EQ(content(*resumed), content(*whole));
  std::shared_ptr<const Transfer> other;
  std::thread second([&] { other = bake_transfer(job(path("shared")), {1, 2}, nullptr, kNever, {}); });
  const auto first = bake_transfer(job(path("shared")), {0, 2}, nullptr, kNever, {});
  second.join();
  EXPECT_EQ(content(*first), content(*whole));
  EXPECT_EQ(content(*other), content(*whole));
  TransferJob by_views = job(path("resumed"));
  by_views.options.joint = false;
  EXPECT_NE(message([&] { bake_transfer(by_views, {}, nullptr, kNever, {}); }).find("prt.form"), std::string::npos);
}

TEST_F(TransferBakeTest, ShowsTheMeansUntilTheRestIsThere) {
  TransferJob job = job_of(plate_and_block(), path("bake"));
  job.parts.push_back({.item = 1, .group = 1});
  job.materials.push_back(test::small_btf(1, 1));
  std::vector<Transfer> shown;
  std::vector<double> progress;
  job.preview = [&](const Transfer& t) { shown.push_back(t); };
  const auto whole = bake_transfer(job, {}, nullptr, kNever, [&](double share) {
    if (shown.empty()) progress.push_back(share);
  });
  ASSERT_EQ(shown.size(), 1u);
  EXPECT_EQ(progress.size(), 2u) << "both means, and no block more";
  ASSERT_EQ(shown[0].bake->groups.size(), 2u);
  for (std::size_t g = 0; g < 2; ++g) {
    const TransferGroup &mean = shown[0].bake->groups[g], &all = whole->bake->groups[g];
    EXPECT_EQ(mean.fit.components, 0);
    EXPECT_EQ(mean.fit.error, all.fit.error_of_mean) << "what the preview misses is said";
    ASSERT_EQ(mean.matrices.size(), 1u);
    EXPECT_EQ(mean.matrices[0].owner, all.matrices[0].owner);
    EXPECT_EQ(mean.matrices[0].weights, all.matrices[0].weights);
  }
  EXPECT_EQ(content(*whole), content(*bake_transfer(job, {}, nullptr, kNever, {})));
  EXPECT_EQ(shown.size(), 1u) << "what is there is not shown in parts";
}

TEST_F(TransferBakeTest, RefusesWhatItIsNotOf) {
  Scene scene = plate_and_block();
  TransferJob job = job_of(scene, path("bake"));
  EXPECT_NE(message([&] {
              TransferJob absent = job;
              absent.may_make = false;
              bake_transfer(absent, {}, nullptr, kNever, {});
            }).find("maquette bake prt"),
            std::string::npos);
  ASSERT_TRUE(bake_transfer(job, {}, nullptr, kNever, {}));
  job.may_make = false;
  EXPECT_EQ(bake_transfer(job, {}, nullptr, kNever, {})->bake->reused, 20u);
  const auto refused = [&](const TransferJob& other) {
    return message([&] { bake_transfer(other, {}, nullptr, kNever, {}); });
  };
  TransferJob clusters = job;
  clusters.options.clusters = 4;
  EXPECT_NE(refused(clusters).find("prt.clusters 3 instead of 4"), std::string::npos) << refused(clusters);
  TransferJob materials = job;
  materials.materials = {test::small_btf(1, 2)};
  EXPECT_NE(refused(materials).find("other materials"), std::string::npos);
  Scene denser = plate_and_block();
  denser.meshes[0].primitives[0] = test::make_grid({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 6, 0);
  EXPECT_NE(refused([&] {
              TransferJob j = job_of(denser, path("bake"));
              j.may_make = false;
              return j;
            }())
                .find("another mesh"),
            std::string::npos);
  Scene bent = plate_and_block();
  bent.meshes[0].primitives[0].positions[7].y += 0.1f;
  EXPECT_NE(refused([&] {
              TransferJob j = job_of(bent, path("bake"));
              j.may_make = false;
              return j;
            }())
                .find("have moved"),
            std::string::npos);
  // A damaged block: refused where it may not be made, made again where it may.
  const std::string block = transfer_block_path(job.folder, 3);
  std::filesystem::resize_file(block, std::filesystem::file_size(block) / 2);
  EXPECT_NE(refused(job), "no error");
  job.may_make = true;
  EXPECT_EQ(bake_transfer(job, {}, nullptr, kNever, {})->bake->reused, 19u);
}

TEST_F(TransferBakeTest, KnowsAnotherJointFactorisation) {
  TransferJob job = job_of(plate_and_block(), path("bake"));
  job.options.joint = true;
  job.options.texel_clusters = 2;
  job.options.joint_clusters = 3;
  ASSERT_TRUE(bake_transfer(job, {}, nullptr, kNever, {}));
  EXPECT_EQ(bake_transfer(job, {}, nullptr, kNever, {})->bake->reused, 6u);
  const auto refused = [&](const TransferJob& other) {
    return message([&] { bake_transfer(other, {}, nullptr, kNever, {}); });
  };
  TransferJob clusters = job;
  clusters.options.joint_clusters = 4;
  EXPECT_NE(refused(clusters).find("prt.joint_clusters 3 instead of 4"), std::string::npos) << refused(clusters);
  clusters = job;
  clusters.options.texel_clusters = 3;
  EXPECT_NE(refused(clusters).find("prt.texel_clusters 2 instead of 3"), std::string::npos) << refused(clusters);
  // As of a program that factorises the same material in another way.
  Btf other = *job.materials[0];
  for (BtfView& view : other.views)
    for (float& w : view.light_weights) w *= 1.25f;
  TransferJob refitted = job;
  refitted.materials = {std::make_shared<const Btf>(other)};
  ASSERT_EQ(refitted.materials[0]->hash, job.materials[0]->hash);
  EXPECT_NE(refused(refitted).find("another joint factorisation"), std::string::npos) << refused(refitted);
  // In a folder of the cache it is made again.
  refitted.must_work = false;
  const auto again = bake_transfer(refitted, {}, nullptr, kNever, {});
  EXPECT_EQ(again->bake->reused, 0u);
  TransferJob apart = refitted;
  apart.folder.clear();
  EXPECT_EQ(content(*again), content(*bake_transfer(apart, {}, nullptr, kNever, {})));
  EXPECT_EQ(bake_transfer(refitted, {}, nullptr, kNever, {})->bake->reused, 6u);
}

TEST_F(TransferBakeTest, RefusesDamagedManifestsAndMakesThemAgain) {
  TransferJob job = job_of(plate_and_block(), path("bake"));
  ASSERT_TRUE(bake_transfer(job, {}, nullptr, kNever, {}));
  const std::string manifest = transfer_manifest_path(job.folder);
  for (const std::uintmax_t size : {std::uintmax_t{0}, std::filesystem::file_size(manifest) / 2}) {
    std::filesystem::resize_file(manifest, size);
    job.may_make = false;
    EXPECT_NE(message([&] { bake_transfer(job, {}, nullptr, kNever, {}); }).find(manifest), std::string::npos);
    job.may_make = true;
    EXPECT_EQ(bake_transfer(job, {}, nullptr, kNever, {})->bake->reused, 20u);
  }
}

TEST_F(TransferBakeTest, RefusesNumbersThatAreNotFinite) {
  for (const bool factors : {false, true}) {
    Btf btf = *test::small_btf(2, 2);
    if (factors)
      btf.views[4].factors[3] = half_of_float(std::nanf(""));
    else
      btf.views[4].light_weights[3] = std::nanf("");
    Scene scene = plate_and_block();
    scene.materials[0].name = "cover";
    scene.materials[0].measured = path("bad.exr");
    TransferInput input;
    const std::string told = message([&] {
      save_btf(path("bad.exr"), btf);
      input.scene = std::make_shared<Scene>(scene);
      input.geometry = std::make_shared<const FlatGeometry>(flatten(scene));
      MeasuredLibrary library;
      make_transfer_job(input, path("out"), &library);
    });
    EXPECT_NE(told.find("bad.exr"), std::string::npos) << told;
  }
}

TEST_F(TransferBakeTest, StandsTrianglesThatShareNoVertices) {
  // Each corner stands for itself, and one vertex belongs to nothing.
  Scene scene = plate_and_block();
  Primitive& plate = scene.meshes[0].primitives[0];
  const Primitive shared = plate;
  plate.positions.clear(), plate.normals.clear(), plate.indices.clear();
  plate.tangents.clear(), plate.uvs[0].clear();
  for (const std::uint32_t i : shared.indices) {
    plate.indices.push_back(static_cast<std::uint32_t>(plate.positions.size()));
    plate.positions.push_back(shared.positions[i]);
    if (!shared.normals.empty()) plate.normals.push_back(shared.normals[i]);
    if (!shared.tangents.empty()) plate.tangents.push_back(shared.tangents[i]);
    if (!shared.uvs[0].empty()) plate.uvs[0].push_back(shared.uvs[0][i]);
  }
  const auto found = bake_transfer(job_of(scene, {}), {}, nullptr, kNever, {});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->mesh.vertices.size(), shared.indices.size());
  for (const float e : found->bake->groups[0].errors) EXPECT_TRUE(e >= 0.0f && e < 1.0f);
}

TEST_F(TransferBakeTest, KnowsWhereItsPartsWereTurned) {
  Scene scene = plate_and_block();
  ASSERT_TRUE(bake_transfer(job_of(scene, path("bake")), {}, nullptr, kNever, {}));
  const auto still = [&](const Scene& s, bool shows) {
    TransferJob job = job_of(s, path("bake"));
    job.may_make = false;
    job.show_stale = shows;
    return bake_transfer(job, {}, nullptr, kNever, {});
  };
  // All of it together: the same bake, in a turned frame.
  Scene turned = plate_and_block();
  for (const std::size_t node : {0u, 1u}) turn(&turned, node, 25.0);
  const auto found = still(turned, false);
  EXPECT_EQ(found->stale, "");
  const glm::dvec3 up =
      glm::dmat3(glm::rotate(glm::dmat4(1.0), glm::radians(25.0), glm::dvec3(0.3, 0.8, -0.5))) * glm::dvec3(0, 1, 0);
  EXPECT_LT(glm::length(found->baked_from_world * up - glm::dvec3(0, 1, 0)), 1e-5);
  // The plate alone, below a block that stays: stale.
  Scene alone = plate_and_block();
  turn(&alone, 0, 25.0);
  EXPECT_NE(message([&] { still(alone, false); }).find("did not turn along"), std::string::npos);
  EXPECT_NE(still(alone, true)->stale, "");
  // In memory, too: nothing is made again.
  const auto first = bake_transfer(job_of(scene, {}), {}, nullptr, kNever, {});
  EXPECT_EQ(bake_transfer(job_of(turned, {}), {}, first->bake, kNever, {})->bake, first->bake);
  EXPECT_NE(bake_transfer(job_of(alone, {}), {}, first->bake, kNever, {})->bake, first->bake);
}

TEST_F(TransferBakeTest, LeavesOutAGroundThatWasAdded) {
  Scene scene = plate_and_block();
  const std::size_t own = scene.nodes.size();
  add_ground(&scene, *test::constant_sky(1.0f), {});
  ASSERT_GT(scene.nodes.size(), own);
  TransferInput input;
  input.scene = std::make_shared<Scene>(scene);
  input.geometry = std::make_shared<const FlatGeometry>(flatten(scene));
  EXPECT_EQ(find_transfer_items(input).size(), 2u);
  EXPECT_EQ(input.geometry->items.size(), 3u);
  MeasuredLibrary library;
  const TransferJob job = make_transfer_job(input, path("out"), &library);
  EXPECT_EQ(job.parts.size(), 2u);
  EXPECT_TRUE(job.occluding[2]) << "it hides the sky below";
}

TEST(RigidMotion, IsFoundOrNot) {
  std::vector<glm::vec3> points, moved, mirrored;
  const glm::dmat3 turn(glm::rotate(glm::dmat4(1.0), 2.1, glm::normalize(glm::dvec3(1.0, -2.0, 0.5))));
  for (int i = 0; i < 40; ++i) {
    points.emplace_back(std::sin(1.3 * i), std::cos(2.1 * i), 0.05 * i);
    moved.emplace_back(turn * glm::dvec3(points.back()) + glm::dvec3(3.0, 1.0, -2.0));
    mirrored.emplace_back(-points.back().x, points.back().y, points.back().z);
  }
  const auto motion = find_rigid_motion(points, moved);
  ASSERT_TRUE(motion);
  for (int k = 0; k < 3; ++k) EXPECT_LT(glm::length(motion->rotation[k] - turn[k]), 1e-5);
  EXPECT_FALSE(find_rigid_motion(points, mirrored));
  moved[5].x += 0.01f;
  EXPECT_FALSE(find_rigid_motion(points, moved));
  EXPECT_FALSE(find_rigid_motion(points, {}));
}

TEST_F(TransferBakeTest, NamesShadowsAndSurfacesThatItDoesNotHold) {
  Scene scene = plate_and_block();
  scene.materials.push_back(test::matte(glm::vec3(0.3f)));
  scene.materials.back().name = "net";
  scene.meshes[1].primitives[0].material = 1;
  TransferInput input;
  MeasuredLibrary library;
  const auto left_out = [&](AlphaMode mode, const char* parts) {
    scene.materials[1].alpha_mode = mode;
    input.scene = std::make_shared<Scene>(scene);
    input.geometry = std::make_shared<const FlatGeometry>(flatten(scene));
    input.settings.set("prt.parts", std::string(parts));
    std::string all;
    for (const std::string& line : make_transfer_job(input, path("out"), &library).left_out) all += line + "\n";
    return all;
  };
  EXPECT_EQ(left_out(AlphaMode::opaque, "plate"), "");
  EXPECT_NE(left_out(AlphaMode::mask, "plate").find("of net as whole where they cast shadows"), std::string::npos);
  const std::string shadow = left_out(AlphaMode::blend, "plate"), own = left_out(AlphaMode::blend, "");
  EXPECT_NE(shadow.find("no shadow of surfaces of net"), std::string::npos) << shadow;
  EXPECT_EQ(shadow.find("their own light"), std::string::npos) << "another mode shades them";
  EXPECT_NE(own.find("no transfer for surfaces of net"), std::string::npos) << own;
  input.settings.set("prt.shadows", std::string("parts"));
  EXPECT_EQ(left_out(AlphaMode::blend, "plate"), "");
}

TEST_F(TransferBakeTest, MaterialsBecomeBtfsOrAreRefusedByName) {
  Scene scene = plate_and_block();
  scene.materials.push_back(test::matte(glm::vec3(0.3f, 0.6f, 0.9f)));
  scene.materials.back().name = "rough metal";
  scene.materials.back().metallic = 1.0f;
  scene.materials.back().roughness = 0.6f;
  scene.meshes[1].primitives[0].material = 1;
  save_btf(path("small.exr"), *test::small_btf(4, 2));
  TransferInput input;
  input.scene = std::make_shared<Scene>(scene);
  input.geometry = std::make_shared<const FlatGeometry>(flatten(scene));
  MeasuredLibrary library;
  const TransferJob job = make_transfer_job(input, path("out"), &library);
  ASSERT_EQ(job.materials.size(), 2u);
  EXPECT_EQ(job.parts[0].tiles_per_uv_x, 0.0f);
  // Of a Lambert material: its albedo over pi, whatever the light.
  const BtfView& view = job.materials[0]->views[40];
  std::vector<glm::vec3> factors(4);
  read_btf_factors(*job.materials[0], view, {}, factors.data());
  EXPECT_NEAR(factors[0].x, 0.5f / 3.14159265f, 1e-3f);
  EXPECT_NEAR(evaluate_btf(*job.materials[1], {}, glm::normalize(glm::vec3(0.1f, 0.2f, 1.0f)),
                           glm::normalize(glm::vec3(0.0f, -0.3f, 1.0f)))
                      .z /
                  evaluate_btf(*job.materials[1], {}, glm::normalize(glm::vec3(0.1f, 0.2f, 1.0f)),
                               glm::normalize(glm::vec3(0.0f, -0.3f, 1.0f)))
                      .x,
              3.0f, 0.2f);
  scene.materials[1].measured = path("small.exr");
  input.scene = std::make_shared<Scene>(scene);
  EXPECT_EQ(make_transfer_job(input, path("out"), &library).materials[1]->views.size(), 19u);
  scene.images.push_back(test::checkerboard());
  scene.materials[0].name = "checked";
  scene.materials[0].base_color_texture.image = 0;
  input.scene = std::make_shared<Scene>(scene);
  const TransferJob textured = make_transfer_job(input, path("out"), &library);
  EXPECT_EQ(textured.materials[0]->width, 8);
  EXPECT_EQ(textured.parts[0].tiles_per_uv_x, 1.0f);
  // Texel 1 of the checkerboard is bright in red, texel 0 dark.
  for (const auto& [x, code] : {std::pair(0.5f, 20.0), std::pair(1.5f, 255.0)})
    EXPECT_NEAR(evaluate_btf(*textured.materials[0], {{x / 8.0f, 0.5f / 8.0f}, 0.0f}, {0, 0, 1}, {0, 0, 1}).x,
                0.5 * linear_from_srgb(code / 255.0) / 3.14159265, 1e-3);
  scene.materials[0].normal_texture.image = 0;
  input.scene = std::make_shared<Scene>(scene);
  EXPECT_NE(message([&] { make_transfer_job(input, path("out"), &library); }).find("checked"), std::string::npos);
  input.settings.set("prt.parts", std::string("block"));
  EXPECT_EQ(make_transfer_job(input, path("out"), &library).parts.size(), 1u);
  input.settings.set("prt.faces", 12);
  EXPECT_NE(message([&] { make_transfer_job(input, path("out"), &library); }).find("power of two"), std::string::npos);
}

}  // namespace
}  // namespace maquette
