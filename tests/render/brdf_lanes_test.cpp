// Queries prepared in SIMD lanes, against the same queries prepared one by one.
#include "render/reference/brdf_lanes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <random>

#include "render/reference/path_scene.h"
#include "render/reference/scattering.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

/// Above the horizon; often grazing, upright, or the mirror direction of `other`.
glm::vec3 awkward_direction(std::mt19937* random, const glm::vec3& other) {
  std::uniform_real_distribution<float> side(-1.0f, 1.0f);
  const auto kind = (*random)() % 8;
  if (kind == 0) return {0.0f, 0.0f, 1.0f};
  if (kind == 1) return {-other.x, -other.y, other.z};
  if (kind == 2) return other;
  const float height = kind == 3 ? 1e-6f : std::abs(side(*random)) + 1e-4f;
  return glm::normalize(glm::vec3(side(*random), side(*random), height));
}

TEST(BrdfLanes, MatchTheSharedFormulas) {
  std::mt19937 random(3);
  const BrdfTables none;
  shared::BrdfSampler sampler(none);
  for (int round = 0; round < 20000; ++round) {
    BrdfLanes lanes;
    std::array<glm::vec3, BrdfLanes::kCount> wi{}, wo{};
    for (std::size_t i = 0; i < BrdfLanes::kCount; ++i) {
      wo[i] = awkward_direction(&random, {0.0f, 0.0f, 1.0f});
      wi[i] = awkward_direction(&random, wo[i]);
      lanes.wi.set(i, wi[i]);
      lanes.wo.set(i, wo[i]);
    }
    lanes.compute();
    for (std::size_t i = 0; i < BrdfLanes::kCount; ++i) {
      const PackedBrdf::Cell cell = lanes.cell(i);
      const PackedBrdf::Cell alone = PackedBrdf::cell_of(shared::merl_cell(shared::merl_coordinates(wi[i], wo[i])));
      for (std::size_t corner = 0; corner < 8; ++corner) ASSERT_EQ(cell.entry(corner), alone.entry(corner));
      ASSERT_EQ(cell.fraction, alone.fraction);
      const auto half = sampler.half_vector_position(wo[i], wi[i]);
      ASSERT_EQ(lanes.coordinates.t[i], half.t);
      ASSERT_EQ(lanes.coordinates.phi[i], half.phi);
      ASSERT_EQ(lanes.coordinates.length_sum[i], half.length_sum);
      ASSERT_EQ(lanes.coordinates.elevation[i], sampler.brdf_elevation(wo[i]));
    }
  }
}

/// Any number of queries, measured and other materials mixed.
TEST(BrdfLanes, BatchesMatchSingleQueries) {
  std::mt19937 random(4);
  Material measured, matte = test::white_lambert();
  measured.measured = "builtin:paint-red-metallic";
  const auto scene_of = [](const Material& m) {
    return build_path_scene({.scene = test::sphere_of(m), .environment = test::constant_sky(1.0f)});
  };
  const std::array scenes{scene_of(measured), scene_of(matte)};
  for (std::size_t count = 0; count < 40; ++count) {
    std::deque<SurfacePoint> points;
    std::deque<ScatteringQuery> queries;
    std::deque<BrdfQuery> plain;
    QueryBatch batch;
    for (std::size_t i = 0; i < count; ++i) {
      SurfacePoint& p = points.emplace_back();
      p.material = &scenes[random() % 4 == 0 ? 1 : 0]->materials[0];
      p.wo = awkward_direction(&random, {0.0f, 0.0f, 1.0f});
      const glm::vec3 wi = awkward_direction(&random, p.wo);
      queries.emplace_back().wi = wi;
      plain.emplace_back().wi = wi;
      batch.add(p, &queries.back());
      if (i % 3 == 0) batch.add(p, &plain.back());
    }
    batch.complete();
    for (std::size_t i = 0; i < count; ++i) {
      const Scattering alone = evaluate_scattering(points[i], prepare_scattering(points[i], queries[i].wi));
      const Scattering together = evaluate_scattering(points[i], queries[i]);
      EXPECT_EQ(together.f, alone.f) << count << " " << i;
      EXPECT_EQ(together.pdf, alone.pdf) << count << " " << i;
      if (i % 3 == 0) {
        EXPECT_EQ(evaluate_brdf(points[i], plain[i]), alone.f) << count << " " << i;
      }
    }
  }
}

}  // namespace
}  // namespace maquette
