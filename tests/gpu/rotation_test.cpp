// Frames while only the environment rotates: points reuse their history without bias, and start again after every other
// change.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "render/bandwidth/temporal_reuse.h"
#include "render/gbuffer/tiles.h"
#include "render/gl/context.h"
#include "render/metrics/metrics.h"
#include "render/renderer.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

class Rotating : public ::testing::Test {
 protected:
  Rotating() { show("builtin:leather-black"); }

  void show(const std::string& material) {
    scene_ = std::make_shared<Scene>(load_scene("builtin:sphere"));
    renderer_.set_scene(scene_);
    renderer_.set_environment(std::make_shared<Environment>(load_environment("builtin:clear-sky")));
    renderer_.set_material("*", material);
  }
  static FrameRequest request() {
    FrameRequest r;
    r.camera.eye = {0.0f, 0.0f, 4.5f};
    r.camera.fov_y_rad = 0.5236f;
    r.width = r.height = 64;
    r.settings.set_from_text("shading.visibility", "none");
    return r;
  }
  /// Frames that arrive at the request's rotation in steps of `step_rad`.
  FrameStats rotate(FrameRequest r, int frames, float step_rad = 0.035f) {
    const float end = r.env_rotation_rad;
    FrameStats stats;
    for (int f = 0; f < frames; ++f) {
      r.env_rotation_rad = end - static_cast<float>(frames - 1 - f) * step_rad;
      stats = renderer_.render(r);
    }
    return stats;
  }
  Image drawn_without_reuse(FrameRequest r) {
    r.settings.set("shading.reuse", false);
    renderer_.render(r);
    return renderer_.read_radiance();
  }
  /// The same count and density of points as in frames with temporal reuse.
  static FrameRequest as_while_rotating(FrameRequest r) {
    r.samples = 32;
    r.settings.set_from_text("bandwidth.quality", "0.65");
    return r;
  }
  struct OverSeeds {
    Image mean = Image(64, 64, 4);
    double single = 0.0;  ///< root of the mean square of single pictures' differences to the truth
  };
  /// `picture_of`: of a request that differs in its seed alone.
  template <typename PictureOf>
  static OverSeeds over_seeds(int seeds, const FrameRequest& r, const Image& truth, PictureOf picture_of) {
    OverSeeds result;
    double square = 0.0;
    for (int seed = 0; seed < seeds; ++seed) {
      FrameRequest one = r;
      one.seed = static_cast<std::uint32_t>(seed);
      const Image picture = picture_of(one);
      square += std::pow(difference(picture, truth), 2.0) / seeds;
      for (std::size_t i = 0; i < result.mean.data.size(); ++i)
        result.mean.data[i] += picture.data[i] / static_cast<float>(seeds);
    }
    result.single = std::sqrt(square);
    return result;
  }
  Image converged(FrameRequest r, std::uint32_t seed) {
    r.mode = "uniform";
    r.samples = 1024;
    r.seed = seed;
    for (int f = 0; f < 8; ++f) renderer_.render(r, true);
    return renderer_.read_radiance();
  }
  static double difference(const Image& a, const Image& b) { return compare_images(a, b).relative_rmse.value(); }
  static double continued(const FrameStats& stats) {
    const auto found = stats.technique.find("continued_points");
    return found == stats.technique.end() ? -1.0 : found->second;
  }
  void TearDown() override { EXPECT_TRUE(take_gl_errors().empty()); }

  GlContext context_ = GlContext::create_headless();
  std::shared_ptr<Scene> scene_;
  Renderer renderer_;
};

TEST_F(Rotating, FewerSamplesGiveNoLargerError) {
  for (const char* material : {"builtin:leather-black", "builtin:paint-red-metallic", "builtin:metal-chrome"}) {
    show(material);
    const FrameRequest r = request();
    const Image truth = converged(r, 77);
    double rotated_square = 0.0, fresh_square = 0.0, rotated_samples = 0.0, fresh_samples = 0.0;
    for (std::uint32_t seed = 0; seed < 4; ++seed) {
      FrameRequest one = r;
      one.seed = seed;
      const FrameStats stats = rotate(one, 30);
      rotated_square += std::pow(difference(renderer_.read_radiance(), truth), 2.0);
      rotated_samples += static_cast<double>(stats.shading_samples);
      one.settings.set("shading.reuse", false);
      fresh_samples += static_cast<double>(renderer_.render(one).shading_samples);
      fresh_square += std::pow(difference(renderer_.read_radiance(), truth), 2.0);
    }
    RecordProperty(std::string(material) + " error", std::to_string(std::sqrt(rotated_square / fresh_square)));
    RecordProperty(std::string(material) + " samples", std::to_string(rotated_samples / fresh_samples));
    EXPECT_LT(rotated_square, 1.5 * 1.5 * fresh_square) << material;
    if (std::string(material) == "builtin:leather-black") {
      EXPECT_LT(rotated_samples, 0.5 * fresh_samples);
    }
  }
}

TEST_F(Rotating, RotationLeavesNoBias) {
  // Steps so long that a plain mean of the last frames would show the light of earlier rotations.
  const FrameRequest r = request();
  const Image truth = converged(r, 77);
  constexpr int kSeeds = 24;
  const OverSeeds rotated = over_seeds(kSeeds, r, truth, [&](const FrameRequest& one) {
    EXPECT_GT(continued(rotate(one, 12, 0.1f)), 0.0);
    return renderer_.read_radiance();
  });
  // The same count of frames without reuse has only the errors of interpolation and the remaining noise.
  const OverSeeds fresh = over_seeds(
      kSeeds, r, truth, [&](const FrameRequest& one) { return drawn_without_reuse(as_while_rotating(one)); });
  const double left = difference(rotated.mean, truth), left_fresh = difference(fresh.mean, truth);
  RecordProperty("rotating", std::to_string(left));
  RecordProperty("without reuse", std::to_string(left_fresh));
  EXPECT_LT(left, std::hypot(left_fresh, 1.5 * rotated.single / std::sqrt(kSeeds))) << left_fresh;
}

TEST_F(Rotating, TheSeparateSunIsTheSameLight) {
  // The sun is sampled separately at every point while the environment rotates: for broad lobes, for one as narrow as
  // the sun, and for a mirror that finds it by its own samples.
  const auto two_suns = [](float sky) {
    Environment e;
    e.width = 512;
    e.height = 256;
    e.rgb.assign(512 * 256, glm::vec3(sky));
    e.rgb[70 * 512 + 250] = glm::vec3(1e6f, 9e5f, 8e5f);
    if (sky > 0.0f) e.rgb[60 * 512 + 330] = glm::vec3(4e5f);
    return std::make_shared<Environment>(e);
  };
  const std::shared_ptr<Environment> skies[] = {std::make_shared<Environment>(load_environment("builtin:clear-sky")),
                                                two_suns(1.0f), two_suns(0.0f)};
  for (const char* material : {"builtin:leather-black", "builtin:plastic-piano-black", "builtin:metal-chrome"}) {
    for (const auto& sky : skies) {
      show(material);
      renderer_.set_environment(sky);
      const FrameRequest r = request();
      const Image truth = converged(r, 77), other = converged(r, 78);
      constexpr int kSeeds = 6;
      const OverSeeds rotated = over_seeds(kSeeds, r, truth, [&](FrameRequest one) {
        one.settings.set("bandwidth.max_level", 0);  // nothing is interpolated
        EXPECT_GE(continued(rotate(one, 4)), 0.0);
        return renderer_.read_radiance();
      });
      const Image& mean = rotated.mean;
      const double noise = std::hypot(rotated.single / std::sqrt(kSeeds), difference(truth, other));
      // If one or two pixels mirror all of the light this is a single normal deviate.
      EXPECT_LT(difference(mean, truth), 2.5 * noise + 0.003) << material << " " << sky->name;
      double sums[2] = {};
      for (std::size_t i = 0; i < mean.data.size(); i += 4) {
        sums[0] += static_cast<double>(mean.data[i + 1]);
        sums[1] += static_cast<double>(truth.data[i + 1]);
      }
      EXPECT_NEAR(sums[0] / sums[1], 1.0, 0.01) << material << " " << sky->name;
      RecordProperty(std::string(material) + sky->name, std::to_string(sums[0] / sums[1]));
    }
  }
}

TEST_F(Rotating, ALightThatJumpsLeavesNoGhost) {
  FrameRequest r = request();
  rotate(r, 20);
  r.env_rotation_rad = 0.3f;
  renderer_.render(r);
  const Image leapt = renderer_.read_radiance(), truth = converged(r, 77);
  EXPECT_LT(difference(leapt, truth), 1.5 * difference(drawn_without_reuse(as_while_rotating(r)), truth));
  // For all distances, and in consecutive frames: fast moves of the mouse must not make frames slow.
  for (int jump = 1; jump <= 3; ++jump) {
    const FrameRequest before = r;
    r.env_rotation_rad = 2.0f * static_cast<float>(jump);
    const Image there = converged(r, 77);
    // A ghost is an error that all seeds have in common; single frames have 32 samples under a sun, and 1.2 to 1.55
    // times the error of the others.
    constexpr int kSeeds = 16;
    const OverSeeds jumped = over_seeds(kSeeds, r, there, [&](const FrameRequest& one) {
      FrameRequest from = before;
      from.seed = one.seed;
      rotate(from, 4);
      EXPECT_GE(continued(renderer_.render(one)), 0.0) << jump;
      return renderer_.read_radiance();
    });
    const OverSeeds fresh = over_seeds(
        kSeeds, r, there, [&](const FrameRequest& one) { return drawn_without_reuse(as_while_rotating(one)); });
    // The difference of both means beyond their noise, against the error of single frames.
    const auto variance = [&](const OverSeeds& o) {
      return (o.single * o.single - std::pow(difference(o.mean, there), 2.0)) / (kSeeds - 1);
    };
    const double apart = std::pow(difference(jumped.mean, fresh.mean), 2.0) - variance(jumped) - variance(fresh);
    EXPECT_LT(std::sqrt(std::max(apart, 0.0)), 0.2 * fresh.single) << jump;
    EXPECT_LT(jumped.single, 1.65 * fresh.single) << jump;
  }
}

TEST_F(Rotating, TheFirstFrameAfterRestNeedsNoMoreSamplesThanOthers) {
  FrameRequest r = request();
  for (int f = 0; f < 4; ++f) renderer_.render(r, true);
  r.env_rotation_rad = 0.035f;
  const FrameStats first = renderer_.render(r);
  EXPECT_EQ(continued(first), 0.0);  // scheduled, but no point has a history
  const Image picture = renderer_.read_radiance();
  r.env_rotation_rad += 0.035f;
  EXPECT_GT(continued(renderer_.render(r)), 0.0);
  r.env_rotation_rad -= 0.035f;
  const Image truth = converged(r, 77);
  EXPECT_LT(difference(picture, truth), 1.5 * difference(drawn_without_reuse(as_while_rotating(r)), truth));
  FrameRequest without_reuse = r;
  without_reuse.settings.set("shading.reuse", false);
  EXPECT_LT(static_cast<double>(first.shading_samples),
            0.6 * static_cast<double>(renderer_.render(without_reuse).shading_samples));
}

TEST_F(Rotating, ASlowFrameIsNotFollowedByAnother) {
  // Steps of all sizes cost about the same: otherwise a rotation of constant speed would take larger steps after each
  // slow frame.
  show("builtin:paint-red-metallic");
  double least = 1e30, most = 0.0;
  for (const float step_rad : {0.02f, 0.1f, 0.4f, 1.2f}) {
    const FrameStats stats = rotate(request(), 16, step_rad);
    const double points = static_cast<double>(stats.shaded_pixels);
    const double looking_back = 8.0 * continued(stats);
    const double cost = (static_cast<double>(stats.shading_samples) + (kLookingBack - 1.0) * looking_back) / points;
    least = std::min(least, cost);
    most = std::max(most, cost);
  }
  RecordProperty("most over least", std::to_string(most / least));
  EXPECT_LT(most, 2.5 * least);
}

TEST(TurningBudget, PointsThatReuseTheirHistoryAreWithinIt) {
  // Each with the least number of samples, whatever a frame requests.
  for (const auto& [base, fewest] : {std::pair{32, 8}, {2, 2}, {128, 32}, {2048, 512}, {16, 8}}) {
    const double samples = 1000.0 * fewest;
    EXPECT_EQ(budgeted_scale(1.0f, {1000.0, samples, samples}, base, fewest), 1.0f) << base;
  }
}

TEST(TurningBudget, PointsWithoutHistoryShareIt) {
  const ReuseCost cost{1000.0, 80.0 * 1000.0, 0.0};
  const float scale = budgeted_scale(1.0f, cost, 32, 8);
  EXPECT_NEAR(scale, kReuseBudget * 32.0 / 80.0, 1e-5);
  // Costs are linear in the scale here: at that scale the budget is used up, and the scale stays.
  const ReuseCost then{1000.0, scale * cost.samples, 0.0};
  EXPECT_NEAR(budgeted_scale(scale, then, 32, 8), scale, 1e-5);
  // Samples with reuse cost more.
  EXPECT_LT(budgeted_scale(1.0f, {1000.0, 80.0 * 1000.0, 8000.0}, 32, 8), scale);
  EXPECT_EQ(budgeted_scale(1.0f, {1000.0, 1e9, 0.0}, 32, 8), kLeastSampleScale);
  EXPECT_EQ(budgeted_scale(0.5f, {1000.0, 1000.0, 0.0}, 32, 8), 1.0f);
  EXPECT_EQ(budgeted_scale(0.5f, {}, 32, 8), 1.0f);  // nothing visible
}

TEST_F(Rotating, EveryOtherChangeStartsAgain) {
  const auto starts_again = [&](const FrameRequest& r, const char* what) {
    EXPECT_LT(continued(renderer_.render(r)), 0.0) << what;
    const Image picture = renderer_.read_radiance();
    EXPECT_EQ(picture.data, drawn_without_reuse(r).data) << what;
  };
  FrameRequest r = request();
  const auto rotated = [&] {
    EXPECT_GT(continued(rotate(r, 4)), 0.0);
    r.env_rotation_rad += 0.035f;
    return r;
  };
  rotated();
  renderer_.set_environment(std::make_shared<Environment>(load_environment("builtin:studio")));
  starts_again(r, "environment");
  rotated();
  renderer_.set_material("*", "builtin:matte-white");
  starts_again(r, "material");
  rotated();
  Primitive deformed = scene_->meshes[0].primitives[0];
  for (glm::vec3& p : deformed.positions) p.y *= 0.9f;
  renderer_.update_mesh(0, deformed.positions, deformed.normals);
  starts_again(r, "dent");
  rotated();
  r.camera.eye.x += 0.1f;
  starts_again(r, "camera");
  rotated();
  r.env_scale = 2.0f;
  starts_again(r, "scale of the light");
  rotated();
  r.seed = 3;
  starts_again(r, "seed");
  rotated();
  r.width = 80;
  starts_again(r, "size");
  rotated();
  r.mode = "uniform";
  renderer_.render(r);
  r.mode = "bandwidth";
  r.env_rotation_rad += 0.035f;
  starts_again(r, "mode");
  rotated();
  r.settings.set("shading.reuse", false);
  starts_again(r, "switched off");
}

TEST_F(Rotating, TheSameRotationIsTheSamePicture) {
  const FrameRequest r = request();
  rotate(r, 12);
  const Image first = renderer_.read_radiance();
  drawn_without_reuse(r);
  rotate(r, 12);
  EXPECT_EQ(first.data, renderer_.read_radiance().data);
  FrameRequest other = r;
  other.seed = 9;
  rotate(other, 12);
  EXPECT_NE(first.data, renderer_.read_radiance().data);
}

TEST(TileOrder, DependsOnlyOnTheTiles) {
  std::mt19937 random(5);
  for (const std::size_t count : {0u, 1u, 2u, 15u, 16u, 17u, 32u, 33u, 49u, 1000u}) {
    std::vector<unsigned> tiles(count);
    for (std::size_t i = 0; i < count; ++i) tiles[i] = static_cast<unsigned>(i % 40 + (i / 40 << 16));
    const std::vector<unsigned> ordered = ordered_tiles(tiles);
    std::vector<unsigned> sorted = ordered;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_EQ(sorted, tiles) << count;
    std::shuffle(tiles.begin(), tiles.end(), random);
    EXPECT_EQ(ordered_tiles(tiles), ordered) << count;
  }
  // The first half of the list, for one of two cores, contains tiles of both halves of the picture.
  std::vector<unsigned> tiles(100);
  std::iota(tiles.begin(), tiles.end(), 0u);
  const std::vector<unsigned> ordered = ordered_tiles(tiles);
  const auto low = std::count_if(ordered.begin(), ordered.begin() + 50, [](unsigned tile) { return tile < 50u; });
  EXPECT_NEAR(static_cast<double>(low), 25.0, 8.0);
}

TEST_F(Rotating, ABrightMirrorImageIsSampledAgain) {
  // A mirrored sun is found by chance, and then gets a second round of samples. The error is no larger than in a frame
  // without reuse, which is as good since the sun gets all samples of the denser strategy.
  show("builtin:plastic-piano-black");
  const FrameRequest r = request();
  const Image truth = converged(r, 77);
  rotate(r, 20);
  const double rotated = difference(renderer_.read_radiance(), truth);
  EXPECT_LT(rotated, 1.1 * difference(drawn_without_reuse(as_while_rotating(r)), truth));
  EXPECT_LT(rotated, 0.15);
}

}  // namespace
}  // namespace maquette
