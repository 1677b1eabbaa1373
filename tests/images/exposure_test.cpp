// Automatic exposure of real scenes: cabins are legible beside a bright sky, figures for each view.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "render/gl/context.h"
#include "render/picture/tonemap.h"
#include "render/renderer.h"
#include "scenes/luminance.h"
#include "test_paths.h"
#include "viewer/session.h"

namespace maquette {
namespace {

const std::filesystem::path kData = std::filesystem::path(MAQUETTE_SOURCE_DIR) / "../shared/data";

class Exposure : public ::testing::Test {
 protected:
  struct Metered {
    float ev = 0.0f;      ///< against what suits the environment
    double middle = 0.0;  ///< median of the surfaces in the middle half of the picture, as displayed, 0 to 1
  };
  Metered meter(const SceneOptions& options) {
    if (!scene_ || scene_->name != options.scene) {
      scene_ = load_session_scene(options);
      renderer_.set_scene(scene_);
    }
    const auto environment = std::make_shared<const Environment>(load_environment(options.environment));
    renderer_.set_environment(environment);
    const FrameRequest request = make_request(*scene_, options);
    EXPECT_TRUE(renderer_.finish_background_work(request));
    renderer_.render(request);
    const Image radiance = renderer_.read_radiance();
    const float suited = exposure_of(options, *environment), ev = meter_exposure_ev(radiance, suited);
    const Image shown = renderer_.read_display(ev, "pbr-neutral");
    std::vector<double> middle;
    for (int y = shown.height / 4; y < 3 * shown.height / 4; ++y)
      for (int x = shown.width / 4; x < 3 * shown.width / 4; ++x)
        if (radiance.at(x, y, 3) >= 1.0f) middle.push_back(static_cast<double>(luminance(shown, x, y)));
    if (middle.empty()) return {ev - suited, 0.0};
    std::nth_element(middle.begin(), middle.begin() + static_cast<std::ptrdiff_t>(middle.size() / 2), middle.end());
    return {ev - suited, middle[middle.size() / 2]};
  }
  /// Dark leather is dark, but not black, and paint in the sun is not white.
  void expect_legible(const SceneOptions& options, double ev, const std::string& view) {
    const Metered seen = meter(options);
    RecordProperty(view + "_ev", std::to_string(seen.ev));
    RecordProperty(view + "_middle", std::to_string(seen.middle));
    EXPECT_NEAR(static_cast<double>(seen.ev), ev, 0.4) << view;
    EXPECT_GT(seen.middle, 0.1) << view;
    EXPECT_LT(seen.middle, 0.75) << view;
  }

  GlContext context_ = GlContext::create_headless();
  Renderer renderer_;
  std::shared_ptr<const Scene> scene_;
};

TEST_F(Exposure, TheCockpitIsLegibleFromEachCamera) {
  for (const auto& [camera, ev] :
       {std::pair("driver", 2.8), std::pair("passenger", 2.85), std::pair("exterior", 0.8), std::pair("door", 1.4)}) {
    SceneOptions options;
    options.camera = camera;
    options.width = 96;
    options.height = 54;
    options.samples = 16;
    expect_legible(options, ev, camera);
  }
}

TEST_F(Exposure, TheFerrariIsLegibleUnderBothEnvironments) {
  if (!std::filesystem::exists(kData)) GTEST_SKIP() << "needs " << kData;
  for (const auto& [file, ev] : {std::pair("grace_latlong.exr", 0.0), std::pair("autoshop_01_1k.hdr", 0.0)}) {
    SceneOptions options;
    options.scene = (kData / "scenes/ferrari458.glb").string();
    options.environment = (kData / "environments" / file).string();
    options.width = 96;
    options.height = 54;
    options.samples = 16;
    expect_legible(options, ev, file);
  }
}

}  // namespace
}  // namespace maquette
