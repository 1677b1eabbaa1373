#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>

#include "render/math/shared_formulas.h"
#include "render/visibility/visibility_bake.h"
#include "render/visibility/visibility_kind.h"
#include "render/visibility/visibility_points.h"
#include "render/visibility/visibility_sides.h"
#include "tests/support/flat_scenes.h"
#include "tests/support/never.h"

namespace maquette {
namespace {

using namespace test;

class VisibilityCache : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("maquette-visibility-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    const char* before = std::getenv("MAQUETTE_CACHE");
    before_ = before ? before : "";
    had_ = before != nullptr;
    ::setenv("MAQUETTE_CACHE", folder_.c_str(), 1);
  }
  void TearDown() override {
    had_ ? ::setenv("MAQUETTE_CACHE", before_.c_str(), 1) : ::unsetenv("MAQUETTE_CACHE");
    std::filesystem::remove_all(folder_);
  }
  std::filesystem::path folder_;
  std::string before_;
  bool had_ = false;
};

TEST_F(VisibilityCache, RoundTripKeyAndDamage) {
  FlatGeometry g;
  add_grid(&g, {-1.0f, 0.0f, -1.0f}, {0.0f, 0.0f, 2.0f}, {2.0f, 0.0f, 0.0f}, 12);
  add_box(&g, {-0.3f, 0.2f, -0.3f}, {0.4f, 0.6f, 0.5f});
  std::vector<bool> transmits(g.items.size(), false);
  std::vector<Passage> passages(g.items.size());
  const auto load = [&](int* calls) {
    VisibilityKind kind;
    const VisibilityJob job{g, transmits, passages};
    const auto made = make_bake(kind, job, {kNever, [calls](double) { ++*calls; }, {}});
    return made.value ? made.value->bake : nullptr;
  };
  int baked = 0;
  int cached = 0;
  const auto first = load(&baked);
  const auto second = load(&cached);
  ASSERT_TRUE(first && second);
  EXPECT_GT(baked, 1);
  EXPECT_EQ(cached, 1);
  EXPECT_EQ(first->vertices, second->vertices);
  EXPECT_EQ(first->bandwidth, second->bandwidth);
  EXPECT_EQ(first->transmittance, second->transmittance);
  // Another geometry, or other panes, have another cache entry.
  int other = 0;
  transmits[1] = true;
  load(&other);
  EXPECT_GT(other, 1);
  passages[1].share = 0.5f;
  load(&(other = 0));
  EXPECT_GT(other, 1);
  passages[1] = {};
  transmits[1] = false;
  // A damaged entry, then a truncated one: baked again with the same result.
  for (const bool cut : {false, true}) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder_)) {
      if (!entry.is_regular_file()) continue;
      const auto size = entry.file_size();
      if (cut) {
        std::filesystem::resize_file(entry.path(), size / 2);
      } else {
        std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
        file.seekg(static_cast<std::streamoff>(size / 2));
        const char old = static_cast<char>(file.get());
        file.seekp(static_cast<std::streamoff>(size / 2));
        file.put(static_cast<char>(~old));
      }
    }
    int again = 0;
    const auto repaired = load(&again);
    ASSERT_TRUE(repaired);
    EXPECT_GT(again, 1) << (cut ? "cut" : "flipped");
    EXPECT_EQ(repaired->vertices, first->vertices);
  }
}

/// Bits that close column by column of cells along x: 16 columns over `length`, hence a known change per metre.
TEST(VisibilityBandwidth, FollowsTheChangePerMetre) {
  for (int n : {16, 64}) {
    FlatGeometry g;
    const float length = 0.8f;
    add_grid(&g, {0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, length}, {length, 0.0f, 0.0f}, n);
    const std::vector<bool> opaque(1, false);
    const VisibilityPoints points = build_visibility_points(g, opaque, kNever);
    std::vector<VisibilityBits> bits(points.points.size());
    for (std::size_t v = 0; v < g.positions.size(); ++v) {
      for (int b = 0; b < 256; ++b) {
        // Direction b opens where x passes a threshold; the thresholds are evenly spaced over b.
        const float threshold = length * (static_cast<float>((b * 97) % 256) + 0.5f) / 256.0f;
        if (g.positions[v].x > threshold)
          bits[points.point_of_vertex[v]][static_cast<std::size_t>(b / 32)] |= 1u << (b % 32);
      }
    }
    const std::vector<float> bandwidth = compute_visibility_bandwidth(points, bits);
    double sum = 0.0;
    for (float value : bandwidth) sum += value;
    // Every bit changes once along `length`: half a cycle.
    EXPECT_NEAR(sum / static_cast<double>(bandwidth.size()), 0.5 / 0.8, 0.2 * 0.5 / 0.8) << n;
  }
}

TEST(VisibilityBandwidth, StaysFiniteAcrossTinyEdges) {
  FlatGeometry g;
  add_grid(&g, {0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}, {1.0f, 0.0f, 0.0f}, 4);
  add_grid(&g, {0.5f, 0.0f, 0.5f}, {0.0f, 0.0f, 1e-7f}, {1e-7f, 0.0f, 0.0f});
  const VisibilityPoints points = build_visibility_points(g, {false, false}, kNever);
  std::vector<VisibilityBits> bits(points.points.size());
  for (std::size_t i = 0; i < bits.size(); i += 2) bits[i].fill(0xffffffffu);
  const double bound = 0.25 * std::numbers::pi * 16384.0 / points.scale_m;
  for (float value : compute_visibility_bandwidth(points, bits)) {
    EXPECT_TRUE(std::isfinite(value));
    EXPECT_LE(value, bound);
  }
}

}  // namespace
}  // namespace maquette
