// Settled frames: the same bits whatever was drawn before.
#include <gtest/gtest.h>

#include <cstring>

#include "render/gl/context.h"
#include "scenes/node_paths.h"
#include "viewer/look_stage.h"

namespace maquette {
namespace {

bool same_bits(const Image& a, const Image& b) {
  return a.width == b.width && a.height == b.height && a.data.size() == b.data.size() &&
         std::memcmp(a.data.data(), b.data.data(), a.data.size() * sizeof(float)) == 0;
}

class Settled : public testing::Test {
 protected:
  GlContext context_ = GlContext::create_headless();
  std::shared_ptr<const Scene> scene_ = std::make_shared<const Scene>(load_scene("builtin:plate"));

  Look look() const {
    Look look;
    look.camera = camera_by_name(*scene_, camera_names(*scene_).front());
    look.settings.set("shading.visibility", std::string("none"));
    return look;
  }
  static SettledFrame frame(int frames) {
    SettledFrame settled;
    settled.size.width = 64;
    settled.size.height = 36;
    settled.frames = frames;
    return settled;
  }
  Image drawn(LookStage* stage, const Look& look, int frames = 2) {
    stage->render(look, frame(frames));
    return stage->renderer().read_radiance();
  }
};

TEST_F(Settled, NeverDependOnWhatWasDrawnBefore) {
  for (const std::string& mode : builtin_registry().names(TechniqueKind::mode)) {
    if (builtin_registry().find_mode(mode).own_bake) continue;  // minutes
    Look first = look();
    first.mode = mode;
    Look moved = first;
    moved.camera.eye.y += 0.2f;
    Look turned = first;
    turned.edits.env_rotation_deg = 40.0f;
    Look painted = first;
    painted.edits.materials[scene_->materials.front().name] = "builtin:paint-pearl-white";
    LookStage alone(scene_);
    const Image expected = drawn(&alone, first);
    LookStage busy(scene_);
    for (const Look& other : {moved, turned, painted}) {
      drawn(&busy, other, 1);
      EXPECT_TRUE(same_bits(drawn(&busy, first), expected)) << mode;
    }
    EXPECT_FALSE(same_bits(drawn(&busy, moved), expected)) << mode;
    busy.exposure_ev(first);
    EXPECT_TRUE(same_bits(drawn(&busy, first), expected)) << mode << ", after metering";
  }
}

TEST_F(Settled, ExposureIsThatOfTheLook) {
  LookStage stage(scene_);
  Look metered = look();
  const float ev = stage.exposure_ev(metered);
  metered.exposure_ev = 5.0f;  // what a window showed last
  drawn(&stage, metered, 3);
  EXPECT_EQ(stage.exposure_ev(metered), ev);
  metered.edits.env_scale = 4.0f;
  EXPECT_NEAR(stage.exposure_ev(metered), ev - 2.0f, 0.1f);
  metered.auto_exposure = false;
  EXPECT_EQ(stage.exposure_ev(metered), 5.0f);
}

TEST_F(Settled, HiddenNodesAndDentsAreDrawn) {
  scene_ = std::make_shared<const Scene>(load_scene("builtin:seat"));
  LookStage stage(scene_);
  Look plain = look();
  const Image whole = drawn(&stage, plain, 1);
  const std::vector<std::string> paths = node_paths(*scene_);
  std::size_t seat = 0;
  while (scene_->nodes[seat].mesh < 0 || !scene_->meshes[static_cast<std::size_t>(scene_->nodes[seat].mesh)].cage)
    ++seat;
  Look hidden = plain;
  hidden.edits.hidden_nodes = {paths[seat]};
  const Image without = drawn(&stage, hidden, 1);
  EXPECT_FALSE(same_bits(whole, without));
  const Bounds bounds = compute_bounds(*scene_);
  Look dented = plain;
  dented.edits.dents = {{bounds.center(), 0.1f, 2.0f, paths[seat]}};
  EXPECT_FALSE(same_bits(drawn(&stage, dented, 1), whole));
  EXPECT_TRUE(same_bits(drawn(&stage, plain, 1), whole));
}

}  // namespace
}  // namespace maquette
