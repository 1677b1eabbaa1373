// A swap of paint: the points of all other materials are kept, and the picture tends to what a fresh renderer shows.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "render/gl/context.h"
#include "render/metrics.h"
#include "render/renderer.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

Material named(const std::string& name, Material material) {
  material.name = name;
  return material;
}

/// An open box whose floor, back and sides are of three materials.
std::shared_ptr<Scene> painted_box() {
  auto scene = std::make_shared<Scene>(test::box_scene(4, 24, test::matte({0.6f, 0.5f, 0.4f})));
  scene->materials[0].name = "floor";
  scene->materials.push_back(named("back", test::matte({0.2f, 0.3f, 0.7f})));
  scene->materials.push_back(named("sides", test::matte({0.5f, 0.6f, 0.5f})));
  const int of_wall[] = {0, 1, 2, 2};
  for (std::size_t i = 0; i < scene->meshes.size(); ++i) scene->meshes[i].primitives[0].material = of_wall[i];
  return scene;
}

class Repaint : public ::testing::Test {
 protected:
  Repaint() { begin(&renderer_); }
  void begin(Renderer* renderer) {
    renderer->set_scene(scene_);
    renderer->set_environment(sky_);
  }
  static FrameRequest request() {
    FrameRequest r;
    r.camera.eye = {0.3f, 0.2f, 3.4f};
    r.camera.target = {0.0f, -0.1f, 0.0f};
    r.camera.fov_y_rad = 0.7f;
    r.width = 64;
    r.height = 56;
    r.settings.set_from_text("shading.visibility", "none");
    return r;
  }
  static Image draw(Renderer* renderer, const FrameRequest& r, int frames = 0) {
    if (frames == 0) renderer->render(r);
    for (int f = 0; f < frames; ++f) renderer->render(r, true);
    return renderer->read_radiance();
  }
  /// What a renderer shows that never knew another paint.
  Image fresh(const FrameRequest& r, const std::vector<std::pair<std::string, std::string>>& paints, int frames) {
    Renderer renderer;
    begin(&renderer);
    for (const auto& [name, source] : paints) renderer.set_material(name, source);
    renderer.finish_background_work(r);
    return draw(&renderer, r, frames);
  }
  static double difference(const Image& a, const Image& b) { return compare_images(a, b).relative_rmse.value(); }
  /// Pixels that differ although `material` is not seen in them, and those that differ where it is.
  std::pair<int, int> changed_pixels(const Image& a, const Image& b, int material) {
    const Image materials = renderer_.read_debug_view("material");
    std::pair<int, int> changed;
    for (std::size_t i = 0; i < a.data.size(); i += 4) {
      if (std::equal(&a.data[i], &a.data[i] + 4, &b.data[i])) continue;
      ++(static_cast<int>(materials.data[i]) == material && materials.data[i + 3] > 0.0f ? changed.second
                                                                                         : changed.first);
    }
    return changed;
  }
  static bool kept_points(const FrameStats& stats) {
    for (const PlannedPass& pass : stats.plan.passes)
      if (pass.name == "shade") return pass.reason.find("other materials are kept") != std::string::npos;
    return false;
  }
  void TearDown() override { EXPECT_TRUE(take_gl_errors().empty()); }

  GlContext context_ = GlContext::create_headless();
  std::shared_ptr<Scene> scene_ = painted_box();
  std::shared_ptr<Environment> sky_ = std::make_shared<Environment>(load_environment("builtin:clear-sky"));
  Renderer renderer_;
};

TEST_F(Repaint, OtherMaterialsAreLeftAsTheyAre) {
  const FrameRequest r = request();
  for (const int frames : {0, 5}) {
    renderer_.set_material("back", "");
    const Image before = draw(&renderer_, r, frames);
    renderer_.set_material("back", "builtin:paint-red-metallic");
    const FrameStats stats = renderer_.render(r, frames > 0);
    EXPECT_TRUE(kept_points(stats));
    const auto [others, own] = changed_pixels(before, renderer_.read_radiance(), 1);
    // While pictures accumulate, shaded points are filled as well, by weights that a quad of two materials shares.
    EXPECT_LE(others, frames > 0 ? 10 : 0);
    EXPECT_GT(own, 500) << frames;
  }
}

TEST_F(Repaint, TheFirstFrameErrsLittleMoreThanOneFromNothing) {
  const FrameRequest r = request();
  renderer_.set_material("back", "builtin:rubber-black");
  draw(&renderer_, r);
  renderer_.set_material("back", "builtin:paint-red-metallic");
  const Image swapped = draw(&renderer_, r);
  FrameRequest anew = r;
  anew.settings.set("shading.reuse", false);
  const Image from_nothing = draw(&renderer_, anew);
  FrameRequest converging = r;
  converging.mode = "uniform";
  converging.samples = 1024;
  const Image truth = draw(&renderer_, converging, 8);
  EXPECT_LT(difference(swapped, truth), 1.6 * difference(from_nothing, truth));
}

TEST_F(Repaint, PicturesConvergeToThoseOfAFreshRenderer) {
  // In one order and another, several at a time, back again, while pictures accumulate and between single frames.
  const FrameRequest r = request();
  const std::string red = "builtin:paint-red-metallic", chrome = "builtin:metal-chrome",
                    rubber = "builtin:rubber-black";
  draw(&renderer_, r, 10);
  renderer_.set_material("back", red);
  draw(&renderer_, r, 3);
  renderer_.set_material("sides", chrome);
  renderer_.set_material("back", rubber);
  draw(&renderer_, r);
  renderer_.set_material("floor", red);
  draw(&renderer_, r, 12);
  renderer_.set_material("floor", "");
  renderer_.set_material("back", red);
  const Image swapped = draw(&renderer_, r, 24);
  const std::vector<std::pair<std::string, std::string>> paints{{"back", red}, {"sides", chrome}};
  const Image once = fresh(r, paints, 24);
  FrameRequest other = r;
  other.seed = 5;
  const double noise = difference(fresh(other, paints, 24), once);
  RecordProperty("apart", std::to_string(difference(swapped, once)));
  RecordProperty("noise", std::to_string(noise));
  EXPECT_LT(difference(swapped, once), 1.3 * noise);
  EXPECT_LT(noise, 0.02);
}

TEST_F(Repaint, IndirectLightFollows) {
  // The floor gets a dark paint: less light on the walls, although their own points are kept.
  FrameRequest r = request();
  r.settings.set_from_text("shading.visibility", "baked");
  renderer_.finish_background_work(r);
  const Image white = draw(&renderer_, r, 8);
  renderer_.set_material("floor", "builtin:rubber-black");
  EXPECT_TRUE(kept_points(renderer_.render(r, true)));
  renderer_.finish_background_work(r);
  const FrameStats stats = renderer_.render(r, true);
  EXPECT_GT(stats.accumulated_frames, 1) << "its news is no reason to begin anew";
  const Image swapped = draw(&renderer_, r, 16);
  const std::vector<std::pair<std::string, std::string>> paints{{"floor", "builtin:rubber-black"}};
  const Image once = fresh(r, paints, 16);
  FrameRequest other = r;
  other.seed = 5;
  const double noise = difference(fresh(other, paints, 16), once);
  EXPECT_LT(difference(swapped, once), 1.3 * noise);
  EXPECT_GT(difference(white, once), 3.0 * noise);
}

TEST_F(Repaint, WhatIsSeenThroughAndInGlassFollows) {
  auto scene = painted_box();
  Material pane = named("pane", Material());
  pane.glass = true;
  pane.ior = 1.5f;
  scene->materials.push_back(pane);
  test::add(scene.get(), test::make_grid({-0.9f, -0.9f, 1.2f}, {1.4f, 0.0f, -0.6f}, {0.0f, 1.4f, 0.0f}, 2, 3), "pane");
  scene_ = scene;
  begin(&renderer_);
  FrameRequest r = request();
  for (const char* reflections : {"off", "raytraced"}) {
    r.reflections = reflections;
    renderer_.set_material("*", "");
    draw(&renderer_, r, 6);
    renderer_.set_material("back", "builtin:paint-red-metallic");
    renderer_.set_material("sides", "builtin:rubber-black");
    const Image swapped = draw(&renderer_, r, 16);
    const std::vector<std::pair<std::string, std::string>> paints{{"back", "builtin:paint-red-metallic"},
                                                                  {"sides", "builtin:rubber-black"}};
    const Image once = fresh(r, paints, 16);
    FrameRequest other = r;
    other.seed = 5;
    EXPECT_LT(difference(swapped, once), 1.3 * difference(fresh(other, paints, 16), once)) << reflections;
  }
}

/// Largest difference over 1 + the value: panes that are kept with the G-buffer round otherwise than drawn ones.
double largest_difference(const Image& a, const Image& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.data.size(); ++i)
    largest = std::max(largest, std::abs(static_cast<double>(a.data[i]) - b.data[i]) / (1.0 + std::abs(b.data[i])));
  return largest;
}

TEST_F(Repaint, NothingIsKeptBesideAnyOtherChange) {
  const auto begins_anew = [&](const FrameRequest& r, const char* what) {
    EXPECT_FALSE(kept_points(renderer_.render(r))) << what;
    const Image picture = renderer_.read_radiance();
    FrameRequest anew = r;
    anew.settings.set("shading.reuse", false);
    EXPECT_LT(largest_difference(picture, draw(&renderer_, anew)), 1e-4) << what;
  };
  FrameRequest r = request();
  bool red = false;
  const auto swap = [&] {
    red = !red;
    renderer_.set_material("back", red ? "builtin:paint-red-metallic" : "builtin:rubber-black");
  };
  draw(&renderer_, r);
  swap();
  r.camera.eye.x += 0.1f;
  begins_anew(r, "camera");
  draw(&renderer_, r);
  swap();
  r.env_rotation_rad += 0.8f;
  begins_anew(r, "light");
  draw(&renderer_, r);
  swap();
  renderer_.set_environment(std::make_shared<Environment>(load_environment("builtin:studio")));
  begins_anew(r, "environment");
  draw(&renderer_, r);
  swap();
  Primitive bent = scene_->meshes[0].primitives[0];
  for (glm::vec3& p : bent.positions) p.y += 0.1f * p.x;
  renderer_.update_mesh(0, bent.positions, bent.normals);
  begins_anew(r, "dent");
  draw(&renderer_, r);
  swap();
  renderer_.set_material("sides", "builtin:glass");
  begins_anew(r, "a material that is another surface");
  draw(&renderer_, r);
  swap();
  FrameRequest uniform = r;
  uniform.mode = "uniform";
  renderer_.render(uniform);
  begins_anew(r, "another mode in between");
  draw(&renderer_, r);
  swap();
  r.width = 80;
  begins_anew(r, "size");
  r.msaa = 4;
  draw(&renderer_, r);
  swap();
  begins_anew(r, "several points a pixel");
}

TEST_F(Repaint, TexturesOfTheOldMaterialLeaveNoTrace) {
  auto scene = painted_box();
  TextureImage checks;
  checks.width = checks.height = 8;
  for (int i = 0; i < 64; ++i) {
    const std::uint8_t v = (i + i / 8) % 2 ? 255 : 20;
    checks.rgba.insert(checks.rgba.end(), {v, 90, static_cast<std::uint8_t>(255 - v), 255});
  }
  scene->images.push_back(checks);
  scene->materials[1].base_color_texture.image = 0;
  for (Primitive* p : {&scene->meshes[1].primitives[0]})
    for (const glm::vec3& at : p->positions) p->uvs[0].push_back({at.x, at.y});
  scene_ = scene;
  begin(&renderer_);
  const FrameRequest r = request();
  draw(&renderer_, r, 4);
  renderer_.set_material("back", "builtin:paint-red-metallic");
  const Image swapped = draw(&renderer_, r);
  Renderer other;
  begin(&other);
  other.set_material("back", "builtin:paint-red-metallic");
  EXPECT_EQ(swapped.data, draw(&other, r).data);
}

}  // namespace
}  // namespace maquette
