// Pictures of mode slf against mode reference.
#include <gtest/gtest.h>

#include <cmath>

#include "render/gl/context.h"
#include "render/reference/reference.h"
#include "render/renderer.h"
#include "scenes/environment.h"
#include "tests/gpu/light_field_stage.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

struct References {
  Image pictures[2];
};

References references_of(const Scene& scene, const std::shared_ptr<const Environment>& sky, const FrameRequest& r,
                         int paths) {
  References references;
  for (std::uint32_t k = 0; k < 2; ++k) {
    ReferencePicture picture(build_path_scene({.scene = scene, .environment = sky}),
                             {.camera = r.camera, .width = r.width, .height = r.height, .seed = k, .paths = {}});
    picture.add(paths);
    references.pictures[k] = picture.mean();
  }
  return references;
}

/// Relative RMSE without the noise of the references, over the pixels where the mask is above 0 (empty: all) and that
/// no lamp fills.
double error_of(const Image& picture, const References& references, const Image& mask = {}) {
  constexpr double kLamp = 5.0;
  double squares = 0.0, light = 0.0, count = 0.0;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      if (mask.width > 0 && !(mask.at(x, y, 0) > 0.0f)) continue;
      for (int c = 0; c < 3; ++c) {
        const double s = static_cast<double>(picture.at(x, y, c)),
                     a = static_cast<double>(references.pictures[0].at(x, y, c)),
                     b = static_cast<double>(references.pictures[1].at(x, y, c));
        if (a > kLamp) continue;
        squares += (s - a) * (s - b);
        light += 0.5 * (a + b);
        count += 1.0;
      }
    }
  EXPECT_GT(count, 100.0);
  return std::sqrt(std::max(squares, 0.0) / count) / (light / count);
}

/// 1 in the middle third of the picture.
Image middle_of(const FrameRequest& r) {
  Image mask(r.width, r.height, 4);
  for (int y = r.height / 3; y < r.height - r.height / 3; ++y)
    for (int x = r.width / 3; x < r.width - r.width / 3; ++x) mask.at(x, y, 0) = 1.0f;
  return mask;
}

TEST(LightFieldPictures, AgreeWithTheReferenceInABox) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  const auto scene = lit_box();
  const auto sky = test::constant_sky(0.1f);
  renderer.set_scene(scene);
  renderer.set_environment(sky);
  FrameRequest request = request_for(96);
  request.camera.eye = {0.1f, 0.0f, 0.9f};
  request.camera.target = {0.0f, -0.1f, -1.0f};
  request.camera.fov_y_rad = 1.2f;
  const References references = references_of(*scene, sky, request, 64);
  for (const int clusters : {0, 32}) {
    request.settings.set("slf.clusters", clusters);
    EXPECT_LT(error_of(draw(&renderer, request).picture, references), 0.06) << clusters;
  }
  EXPECT_TRUE(take_gl_errors().empty());
}

/// A sheet with holes throws light through them onto the wall, and shows it there.
TEST(LightFieldPictures, CutOutsAreHoles) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  auto scene = lit_box();
  TextureImage holes;
  holes.width = holes.height = 4;
  for (int i = 0; i < 16; ++i) {
    const bool hole = ((i % 4) ^ (i / 4)) % 2 == 1;
    for (const int v : {200, 200, 200, hole ? 0 : 255}) holes.rgba.push_back(static_cast<std::uint8_t>(v));
  }
  scene->images.push_back(holes);
  Material net = test::matte(glm::vec3(0.8f));
  net.name = "net";
  net.alpha_mode = AlphaMode::mask;
  net.double_sided = true;
  net.base_color_texture.image = static_cast<int>(scene->images.size()) - 1;
  scene->materials.push_back(net);
  const int material = static_cast<int>(scene->materials.size()) - 1;
  Primitive sheet = test::make_grid({-0.6f, -0.5f, 0.1f}, {1.2f, 0, 0}, {0, 1.1f, 0}, 1, material);
  sheet.uvs[0] = {{0.0f, 0.0f}, {1.0f, 0.0f}, {0.0f, 1.0f}, {1.0f, 1.0f}};
  test::add(scene.get(), sheet, "net");
  const auto sky = test::constant_sky(0.1f);
  renderer.set_scene(scene);
  renderer.set_environment(sky);
  FrameRequest request = request_for(128);
  request.settings.set("slf.clusters", 0);
  request.camera.eye = {0.1f, 0.0f, 0.9f};
  request.camera.target = {0.0f, -0.1f, -1.0f};
  request.camera.fov_y_rad = 1.2f;
  const References references = references_of(*scene, sky, request, 64);
  const Drawn drawn = draw(&renderer, request);
  EXPECT_LT(error_of(drawn.picture, references), 0.1);
  // Without holes the picture is another one.
  Scene closed = *scene;
  closed.materials.back().alpha_mode = AlphaMode::opaque;
  EXPECT_GT(error_of(drawn.picture, references_of(closed, sky, request, 8)), 0.2);
}

TEST(LightFieldPictures, MirroredRaysShowIt) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  auto scene = lit_box();
  Material chrome;
  chrome.name = "chrome";
  chrome.roughness = 0.0f;
  chrome.metallic = 1.0f;
  scene->materials.push_back(chrome);
  test::add(scene.get(), test::make_grid({-0.9f, -0.9f, 0.2f}, {0.6f, 0, 0}, {0, 0.6f, 0}, 1, 3), "mirror")->reflector =
      true;
  renderer.set_scene(scene);
  renderer.set_environment(test::constant_sky(1.0f));
  FrameRequest request = request_for(32);
  request.reflections = "raytraced";
  request.camera.eye = {-0.4f, -0.4f, 0.95f};
  request.camera.target = {-0.6f, -0.6f, 0.0f};
  request.settings.set("slf.clusters", 0);
  const auto sky = test::constant_sky(1.0f);
  const Drawn drawn = draw(&renderer, request);
  for (const float v : drawn.picture.data) ASSERT_TRUE(std::isfinite(v));
  // The mirror shows what is stored of the walls.
  EXPECT_LT(error_of(drawn.picture, references_of(*scene, sky, request, 64), middle_of(request)), 0.1);
  EXPECT_TRUE(take_gl_errors().empty());
}

/// A slice is the field in one direction of the texels: straight on, what a camera sees that looks along the normal.
TEST(LightFieldPictures, ASliceIsTheFieldInOneDirection) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  Scene scene;
  scene.materials.push_back(test::matte(glm::vec3(0.5f)));
  scene.materials[0].metallic = 1.0f;
  scene.materials[0].roughness = 0.6f;
  test::add(&scene, test::make_grid({-1.0f, -1.0f, 0.0f}, {2.0f, 0, 0}, {0, 2.0f, 0}, 4, 0), "wall");
  renderer.set_scene(std::make_shared<Scene>(scene));
  renderer.set_environment(std::make_shared<Environment>(load_environment("builtin:clear-sky")));
  FrameRequest request = request_for(32);
  request.settings.set("slf.clusters", 0);
  request.camera.eye = {0.0f, 0.0f, 60.0f};
  request.camera.target = {0.0f, 0.0f, 0.0f};
  request.camera.fov_y_rad = 0.04f;
  const Image along = draw(&renderer, request).picture;
  Image slice = renderer.read_debug_view("slf_slice");
  int covered = 0;
  for (int y = 0; y < request.height; ++y)
    for (int x = 0; x < request.width; ++x) {
      if (along.at(x, y, 3) < 1.0f) continue;
      ++covered;
      EXPECT_NEAR(slice.at(x, y, 1), along.at(x, y, 1), 0.04f * along.at(x, y, 1)) << x << " " << y;
    }
  EXPECT_GT(covered, 500);
  request.settings.set("slf.slice_tilt", 70.0);
  renderer.render(request);
  const Image tilted = renderer.read_debug_view("slf_slice");
  const int middle_x = request.width / 2, middle_y = request.height / 2;
  EXPECT_GT(std::abs(tilted.at(middle_x, middle_y, 1) - slice.at(middle_x, middle_y, 1)),
            0.1f * slice.at(middle_x, middle_y, 1))
      << "and another one in another";
}

}  // namespace
}  // namespace maquette
