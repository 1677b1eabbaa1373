// A swap of a material: the points of all other materials are kept, and the picture converges to that of a new
// renderer.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "render/gl/context.h"
#include "render/metrics/metrics.h"
#include "render/renderer.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

Material named(const std::string& name, Material material) {
  material.name = name;
  return material;
}

/// An open box whose floor, back and sides are of three materials.
std::shared_ptr<Scene> box_of_three_materials() {
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
  /// The picture of a new renderer, which never had another material.
  Image fresh(const FrameRequest& r, const std::vector<std::pair<std::string, std::string>>& replaced, int frames) {
    Renderer renderer;
    begin(&renderer);
    for (const auto& [name, source] : replaced) renderer.set_material(name, source);
    renderer.finish_background_work(r);
    return draw(&renderer, r, frames);
  }
  static double difference(const Image& a, const Image& b) { return compare_images(a, b).relative_rmse.value(); }
  /// Numbers of differing pixels without and with `material`.
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
  static bool kept_points(const FrameStats& stats) { return stats.status.tables_swapped; }
  void TearDown() override { EXPECT_TRUE(take_gl_errors().empty()); }

  GlContext context_ = GlContext::create_headless();
  std::shared_ptr<Scene> scene_ = box_of_three_materials();
  std::shared_ptr<Environment> sky_ = std::make_shared<Environment>(load_environment("builtin:clear-sky"));
  Renderer renderer_;
};

TEST_F(Repaint, OtherMaterialsAreUnchanged) {
  const FrameRequest r = request();
  for (const int frames : {0, 5}) {
    renderer_.set_material("back", "");
    const Image before = draw(&renderer_, r, frames);
    renderer_.set_material("back", "builtin:paint-red-metallic");
    const FrameStats stats = renderer_.render(r, frames > 0);
    EXPECT_TRUE(kept_points(stats));
    const auto [others, own] = changed_pixels(before, renderer_.read_radiance(), 1);
    // While pictures accumulate, shaded points are interpolated too, with weights that a quad of two materials shares.
    EXPECT_LE(others, frames > 0 ? 10 : 0);
    EXPECT_GT(own, 500) << frames;
  }
}

TEST_F(Repaint, TheFirstFrameErrsLittleMoreThanOneWithoutReuse) {
  const FrameRequest r = request();
  renderer_.set_material("back", "builtin:rubber-black");
  draw(&renderer_, r);
  renderer_.set_material("back", "builtin:paint-red-metallic");
  const Image swapped = draw(&renderer_, r);
  FrameRequest without_reuse = r;
  without_reuse.settings.set("shading.reuse", false);
  const Image drawn_without_reuse = draw(&renderer_, without_reuse);
  FrameRequest converging = r;
  converging.mode = "uniform";
  converging.samples = 1024;
  const Image truth = draw(&renderer_, converging, 8);
  EXPECT_LT(difference(swapped, truth), 1.6 * difference(drawn_without_reuse, truth));
}

TEST_F(Repaint, PicturesConvergeToThoseOfAFreshRenderer) {
  // In different orders, several at a time, and back, while pictures accumulate and between single frames.
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
  const std::vector<std::pair<std::string, std::string>> replaced{{"back", red}, {"sides", chrome}};
  const Image once = fresh(r, replaced, 24);
  FrameRequest other = r;
  other.seed = 5;
  const double noise = difference(fresh(other, replaced, 24), once);
  RecordProperty("apart", std::to_string(difference(swapped, once)));
  RecordProperty("noise", std::to_string(noise));
  EXPECT_LT(difference(swapped, once), 1.3 * noise);
  EXPECT_LT(noise, 0.02);
}

TEST_F(Repaint, IndirectLightFollows) {
  // The floor gets a dark material: less light on the walls, although their own points are kept.
  FrameRequest r = request();
  r.settings.set_from_text("shading.visibility", "baked");
  renderer_.finish_background_work(r);
  const Image white = draw(&renderer_, r, 8);
  renderer_.set_material("floor", "builtin:rubber-black");
  EXPECT_TRUE(kept_points(renderer_.render(r, true)));
  renderer_.finish_background_work(r);
  const FrameStats stats = renderer_.render(r, true);
  EXPECT_GT(stats.accumulated_frames, 1) << "an update of the indirect light must not restart the accumulation";
  const Image swapped = draw(&renderer_, r, 16);
  const std::vector<std::pair<std::string, std::string>> replaced{{"floor", "builtin:rubber-black"}};
  const Image once = fresh(r, replaced, 16);
  FrameRequest other = r;
  other.seed = 5;
  const double noise = difference(fresh(other, replaced, 16), once);
  EXPECT_LT(difference(swapped, once), 1.3 * noise);
  EXPECT_GT(difference(white, once), 3.0 * noise);
}

TEST_F(Repaint, PicturesThroughAndInGlassFollow) {
  auto scene = box_of_three_materials();
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
    const std::vector<std::pair<std::string, std::string>> replaced{{"back", "builtin:paint-red-metallic"},
                                                                    {"sides", "builtin:rubber-black"}};
    const Image once = fresh(r, replaced, 16);
    FrameRequest other = r;
    other.seed = 5;
    EXPECT_LT(difference(swapped, once), 1.3 * difference(fresh(other, replaced, 16), once)) << reflections;
  }
}

/// Largest difference relative to 1 + the value: kept panes are rounded differently from drawn ones.
double largest_difference(const Image& a, const Image& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.data.size(); ++i)
    largest = std::max(largest, std::abs(static_cast<double>(a.data[i]) - b.data[i]) / (1.0 + std::abs(b.data[i])));
  return largest;
}

TEST_F(Repaint, NothingIsKeptWithAnyOtherChange) {
  const auto begins_anew = [&](const FrameRequest& r, const char* what) {
    EXPECT_FALSE(kept_points(renderer_.render(r))) << what;
    const Image picture = renderer_.read_radiance();
    FrameRequest without_reuse = r;
    without_reuse.settings.set("shading.reuse", false);
    EXPECT_LT(largest_difference(picture, draw(&renderer_, without_reuse)), 1e-4) << what;
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
  Primitive deformed = scene_->meshes[0].primitives[0];
  for (glm::vec3& p : deformed.positions) p.y += 0.1f * p.x;
  renderer_.update_mesh(0, deformed.positions, deformed.normals);
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

TEST_F(Repaint, TexturesOfTheOldMaterialDisappear) {
  auto scene = box_of_three_materials();
  scene->images.push_back(test::checkerboard());
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
