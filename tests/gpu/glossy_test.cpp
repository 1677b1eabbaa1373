// Glossy opaque surfaces that mirror the scene, through the octree and by exact rays: against closed forms, the path
// tracer, and the picture without them.
#include <gtest/gtest.h>

#include <cmath>

#include "render/gl/context.h"
#include "render/reference/reference.h"
#include "render/renderer.h"
#include "scenes/error.h"
#include "tests/support/path_scenes.h"
#include "tests/support/test_scenes.h"

namespace {

using namespace maquette;

Material metal(const glm::vec3& f0, float roughness) {
  Material m;
  m.base_color = glm::vec4(f0, 1.0f);
  m.metallic = 1.0f;
  m.roughness = roughness;
  return m;
}

constexpr float kSphereRadius = 0.35f;
const glm::vec3 kSphereCenter(0.1f, -0.2f, -0.3f);

/// The first walls around [-1, 1]^3, each of its own material 0 to 5, and a sphere of material 6.
Scene room_with_sphere(int walls, const std::function<Material(int)>& wall, const Material& sphere) {
  Scene scene = test::box_scene(walls, 16, wall(0));
  for (int k = 1; k < 6; ++k) scene.materials.push_back(wall(k));
  for (std::size_t k = 0; k < static_cast<std::size_t>(walls); ++k)
    scene.meshes[k].primitives[0].material = static_cast<int>(k);
  scene.materials.push_back(sphere);
  Primitive ball = test::fine_sphere(48);
  for (glm::vec3& p : ball.positions) p = kSphereCenter + kSphereRadius * p;
  ball.material = 6;
  test::add(&scene, ball, "ball");
  return scene;
}

glm::vec3 wall_color(int k) {
  return {0.3f + 0.2f * static_cast<float>(k % 3), 0.9f - 0.12f * static_cast<float>(k), 0.5f};
}

Material unlit(const glm::vec3& radiance) {
  Material m = test::matte(radiance);
  m.unlit = true;
  return m;
}

/// Mode and reflector technique.
using Drawer = std::pair<std::string, std::string>;
FrameRequest glossy_request(const Drawer& drawer, const std::string& glossy) {
  FrameRequest r;
  r.mode = drawer.first;
  r.width = r.height = 64;
  r.samples = 64;
  r.reflections = drawer.second;
  r.camera = {.eye = {0.2f, 0.3f, 0.9f}, .target = kSphereCenter, .fov_y_rad = 0.62f};
  r.settings.set_from_text("shading.visibility", "baked");
  r.settings.set_from_text("octree.depth", "7");
  r.settings.set_from_text("reflections.glossy", glossy);
  r.settings.set_from_text("reflections.resolution", "full");
  return r;
}

struct Drawn {
  Image picture;
  FrameStats stats;
};

class Glossy : public ::testing::TestWithParam<Drawer> {
 protected:
  GlContext context_ = GlContext::create_headless();
  Renderer renderer_;
  void SetUp() override { install_debug_output(); }
  void set(Scene scene, std::shared_ptr<const Environment> sky) {
    renderer_.set_scene(std::make_shared<Scene>(std::move(scene)));
    renderer_.set_environment(std::move(sky));
  }
  Drawn draw(const FrameRequest& request, int frames = 1) {
    EXPECT_TRUE(renderer_.finish_background_work(request));
    Drawn drawn;
    for (int k = 0; k < frames; ++k) drawn.stats = renderer_.render(request, frames > 1);
    drawn.picture = renderer_.read_radiance();
    for (float v : drawn.picture.data) EXPECT_TRUE(std::isfinite(v) && v >= 0.0f);
    const auto errors = take_gl_errors();
    EXPECT_TRUE(errors.empty()) << errors.front();
    return drawn;
  }
};
INSTANTIATE_TEST_SUITE_P(Drawers, Glossy,
                         ::testing::Values(Drawer{"uniform", "octree"}, Drawer{"bandwidth", "octree"},
                                           Drawer{"uniform", "raytraced"}, Drawer{"bandwidth", "raytraced"}),
                         [](const auto& drawer) { return drawer.param.first + "_" + drawer.param.second; });

bool has_pass(const FrameStats& stats, const std::string& name) {
  for (const PlannedPass& pass : stats.plan.passes)
    if (pass.name == name) return true;
  return false;
}

/// Where a pixel's mirrored ray hits the wall, in double.
struct MirroredPoint {
  double cosine = 0.0;
  glm::dvec3 wall{0.0};
  int number = -1;  ///< of the wall
};
std::optional<MirroredPoint> trace_pixel(const FrameRequest& r, int x, int y) {
  const glm::dvec3 eye(r.camera.eye), forward = glm::normalize(glm::dvec3(r.camera.target) - eye);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 1, 0))), up = glm::cross(right, forward);
  const double tan_y = std::tan(0.5 * static_cast<double>(r.camera.fov_y_rad));
  const glm::dvec3 d = glm::normalize(
      forward + tan_y * ((2.0 * (x + 0.5) / r.width - 1.0) * right - (2.0 * (y + 0.5) / r.height - 1.0) * up));
  const glm::dvec3 to = eye - glm::dvec3(kSphereCenter);
  const double radius = static_cast<double>(kSphereRadius), b = glm::dot(to, d);
  const double root = b * b - glm::dot(to, to) + radius * radius;
  if (root <= 0.0) return std::nullopt;
  const glm::dvec3 p = eye + (-b - std::sqrt(root)) * d, n = (p - glm::dvec3(kSphereCenter)) / radius;
  MirroredPoint point;
  point.cosine = -glm::dot(n, d);
  const glm::dvec3 m = glm::reflect(d, n);
  const glm::dvec3 exit = (glm::sign(m) - p) / m;
  const double t = std::min({exit.x, exit.y, exit.z});
  point.wall = p + t * m;
  // Walls in the order of test::box_scene: floor, back, left, right, front, roof.
  if (t == exit.x)
    point.number = m.x > 0.0 ? 3 : 2;
  else if (t == exit.y)
    point.number = m.y > 0.0 ? 5 : 0;
  else
    point.number = m.z > 0.0 ? 4 : 1;
  return point;
}

/// Distance of a point on a wall from the nearest corner, by the larger of its two coordinates.
double inside_of_edge(const glm::dvec3& wall) {
  double second = 0.0, first = 0.0;
  for (int c = 0; c < 3; ++c) {
    const double a = std::abs(wall[c]);
    if (a > first) {
      second = first;
      first = a;
    } else if (a > second) {
      second = a;
    }
  }
  return 1.0 - second;
}

/// A closed room whose walls have known radiances and are not light sources: the sphere shows its reflectance times the
/// radiance of the wall that its mirrored ray hits, and is black without.
TEST_P(Glossy, ASphereShowsAClosedRoomOfKnownRadiance) {
  const glm::dvec3 f0(0.9, 0.8, 0.7);
  set(room_with_sphere(
          6, [](int k) { return unlit(wall_color(k)); }, metal(glm::vec3(f0), 0.02f)),
      test::constant_sky(3.0f));
  // Walls are interpolated between the pixels of a coarse picture.
  for (const auto& [resolution, margin, least] :
       {std::tuple("full", 0.12, 800), std::tuple("half", 0.3, 500), std::tuple("quarter", 0.55, 200)}) {
    SCOPED_TRACE(resolution);
    FrameRequest request = glossy_request(GetParam(), "0.3");
    request.settings.set_from_text("reflections.resolution", resolution);
    const Drawn with = draw(request);
    EXPECT_TRUE(has_pass(with.stats, "glossy"));
    EXPECT_GT(with.stats.technique.at("glossy_rays"), 0.0);
    FrameRequest none = request;
    none.settings.set_from_text("reflections.glossy", "0");
    const Drawn without = draw(none);
    int count = 0, off = 0;
    double dark = 0.0;
    for (int y = 0; y < request.height; ++y)
      for (int x = 0; x < request.width; ++x) {
        const auto point = trace_pixel(request, x, y);
        if (!point || point->cosine < 0.3 || inside_of_edge(point->wall) < margin) continue;
        ++count;
        const double schlick = std::pow(1.0 - point->cosine, 5.0);
        bool far = false;
        for (int c = 0; c < 3; ++c) {
          const glm::vec3 color = wall_color(point->number);
          const double reflectance = f0[c] + (std::max(1.0 - 0.02, f0[c]) - f0[c]) * schlick;
          const double expected = reflectance * static_cast<double>(color[c]);
          far = far || std::abs(static_cast<double>(with.picture.at(x, y, c)) - expected) > 0.02 * expected;
          dark = std::max(dark, static_cast<double>(without.picture.at(x, y, c)));
        }
        off += far;
      }
    EXPECT_GT(count, least);
    EXPECT_LT(off, count / (request.reflections == "octree" || std::string(resolution) != "full" ? 20 : 50));
    EXPECT_LT(dark, 1e-2);
  }
}

/// All surroundings are as bright as the sky: a white mirror shows one, whether its ray hits a wall, the sky, or the
/// border between them, where visibility maps are coarse. No light may count twice.
TEST_P(Glossy, WhereAllIsWhiteNothingCountsTwice) {
  set(room_with_sphere(
          5, [](int) { return unlit(glm::vec3(1.0f)); }, metal(glm::vec3(1.0f), 0.1f)),
      test::constant_sky(1.0f));
  for (const char* visibility : {"baked", "traced"}) {
    SCOPED_TRACE(visibility);
    FrameRequest request = glossy_request(GetParam(), "0.3");
    request.samples = 256;
    request.settings.set_from_text("shading.visibility", visibility);
    const Image image = draw(request).picture;
    double sum = 0.0, count = 0.0, bright = 0.0;
    for (int y = 0; y < request.height; ++y)
      for (int x = 0; x < request.width; ++x) {
        const auto point = trace_pixel(request, x, y);
        if (!point || point->cosine < 0.3) continue;
        const auto v = static_cast<double>(image.at(x, y, 1));
        sum += v;
        count += 1.0;
        bright += v > 1.2;
      }
    EXPECT_GT(count, 800.0);
    EXPECT_NEAR(sum / count, 1.0, std::string(visibility) == "traced" ? 0.03 : 0.06);
    EXPECT_LT(bright, 0.03 * count);  // a lobe whose half sees the sky while its ray hits the wall
  }
}

/// A matte room, open above, with one red wall, lit by the sky alone: against all light.
TEST_P(Glossy, ASphereInARoomIsNearerToThePathTracer) {
  const auto wall = [](int k) { return test::matte(k == 2 ? glm::vec3(0.8f, 0.1f, 0.1f) : glm::vec3(0.6f)); };
  const auto scene = room_with_sphere(5, wall, metal(glm::vec3(0.95f), 0.12f));
  const auto sky =
      test::sky_of(64, 32, [](const glm::dvec3& d) { return glm::dvec3(1.0, 1.0, 1.2) * (1.0 + 0.7 * d.x); });
  set(scene, sky);
  FrameRequest request = glossy_request(GetParam(), "0.3");
  request.samples = 256;
  request.settings.set_from_text("reflections.samples", "128");
  const Image with = draw(request, request.reflections == "octree" ? 1 : 16).picture;
  request.settings.set_from_text("reflections.glossy", "0");
  const Image without = draw(request).picture;
  PictureRequest traced;
  traced.camera = request.camera;
  traced.width = request.width;
  traced.height = request.height;
  ReferencePicture picture(build_path_scene({.scene = scene, .environment = sky}), traced);
  picture.add(512);
  const Image truth = picture.mean();
  double level = 0.0, error_with = 0.0, error_without = 0.0, count = 0.0;
  for (int y = 0; y < request.height; ++y)
    for (int x = 0; x < request.width; ++x) {
      const auto point = trace_pixel(request, x, y);
      // Visibility maps are too coarse for the outline of the opening, and cells at edges contain two walls.
      if (!point || point->cosine < 0.2 || point->wall.y > 0.2 || inside_of_edge(point->wall) < 0.1) continue;
      for (int c = 0; c < 3; ++c) {
        const auto t = static_cast<double>(truth.at(x, y, c));
        level += t;
        error_with += std::abs(static_cast<double>(with.at(x, y, c)) - t);
        error_without += std::abs(static_cast<double>(without.at(x, y, c)) - t);
        count += 1.0;
      }
    }
  EXPECT_GT(count, 2000.0);
  EXPECT_LT(error_with, 0.6 * error_without);  // both include the noise of the paths
  EXPECT_LT(error_with, 0.08 * level);
  RecordProperty("with", std::to_string(error_with / level));
  RecordProperty("without", std::to_string(error_without / level));
}

/// Off, or with nothing glossy in view: no pass, no memory, and the same picture as from a renderer that never used it.
TEST_P(Glossy, WhatIsNotNeededCostsNothing) {
  const auto wall = [](int) { return test::matte(glm::vec3(0.6f)); };
  set(room_with_sphere(5, wall, metal(glm::vec3(0.9f), 0.2f)), test::constant_sky(1.0f));
  FrameRequest request = glossy_request(GetParam(), "0.3");
  FrameRequest off = request;
  off.reflections = "off";
  const Image plain = draw(off).picture;
  const Drawn with = draw(request);
  EXPECT_TRUE(has_pass(with.stats, "glossy"));
  EXPECT_EQ(with.stats.plan.octree, request.reflections == "octree");
  EXPECT_GT(with.stats.gpu_bytes.at("glossy"), 0u);
  EXPECT_NE(with.picture.data, plain.data);
  const auto expect_nothing = [&](const FrameRequest& r) {
    const Drawn drawn = draw(r);
    EXPECT_FALSE(has_pass(drawn.stats, "glossy") || drawn.stats.plan.octree);
    EXPECT_FALSE(drawn.stats.gpu_bytes.contains("glossy") || drawn.stats.gpu_bytes.contains("octree"));
    return drawn.picture;
  };
  FrameRequest none = request;
  none.settings.set_from_text("reflections.glossy", "0");
  EXPECT_EQ(expect_nothing(none).data, plain.data);
  FrameRequest smoother = request;
  smoother.settings.set_from_text("reflections.glossy", "0.19");
  EXPECT_EQ(expect_nothing(smoother).data, plain.data);
  FrameRequest away = request;
  away.camera.eye = {0.0f, 0.5f, 0.5f};
  away.camera.target = {0.0f, 0.5f, 3.0f};
  const Image seen = expect_nothing(away);
  away.reflections = "off";
  EXPECT_EQ(seen.data, draw(away).picture.data);
}

/// What rays meet is kept while no gloss is drawn: it is that of the scene afterwards, whatever changed meanwhile.
TEST_P(Glossy, ShowsWhatChangedWhileItWasOff) {
  const auto wall = [](int k) { return unlit(wall_color(k)); };
  const Scene scene = room_with_sphere(5, wall, metal(glm::vec3(0.9f), 0.1f));
  int back = 0;
  while (scene.nodes[static_cast<std::size_t>(back)].mesh != 1) ++back;
  const FrameRequest request = glossy_request(GetParam(), "0.3");
  FrameRequest none = request;
  none.settings.set_from_text("reflections.glossy", "0");
  const auto hidden_picture = [&](bool draws_before) {
    set(scene, test::constant_sky(1.0f));
    Image before;
    if (draws_before) before = draw(request).picture;
    draw(none);
    renderer_.set_node_visible(back, false);
    draw(none);
    const Image after = draw(request).picture;
    EXPECT_NE(after.data, before.data);
    return after;
  };
  const Image fresh = hidden_picture(false);  // nothing is kept over a change of scene
  EXPECT_EQ(hidden_picture(true).data, fresh.data);
}

/// Only a named part mirrors, whatever reflections.glossy is; techniques that project refuse it.
TEST_P(Glossy, ANamedPartMirrors) {
  Scene scene = room_with_sphere(
      6, [](int k) { return unlit(wall_color(k)); }, metal(glm::vec3(0.9f), 0.1f));
  test::add(&scene, test::make_grid({-0.9f, -0.7f, -0.6f}, {0.5f, 0, 0}, {0, 1.4f, 0}, 2, 6), "plate");
  test::add(&scene,
            test::make_grid({-1, -0.99f, 1}, {2, 0, 0}, {0, 0, -2}, 2, static_cast<int>(scene.materials.size())),
            "mat");
  scene.materials.push_back(test::matte(glm::vec3(0.5f)));
  set(scene, test::constant_sky(1.0f));
  FrameRequest request = glossy_request(GetParam(), "0");
  request.reflectors = {"ball"};
  request.camera.fov_y_rad = 1.2f;
  const Drawn named = draw(request);
  EXPECT_TRUE(has_pass(named.stats, "glossy"));
  request.reflectors.clear();
  request.settings.set_from_text("reflections.glossy", "0.3");
  const Drawn all = draw(request);
  renderer_.set_node_visible(6, false);
  const Drawn without_ball = draw(request);
  renderer_.set_node_visible(6, true);
  double of_ball = 0.0, of_plate = 0.0, plate = 0.0;
  for (int y = 0; y < request.height; ++y)
    for (int x = 0; x < request.width; ++x) {
      const auto value = [&](const Drawn& d) { return static_cast<double>(d.picture.at(x, y, 1)); };
      if (const auto point = trace_pixel(request, x, y)) {
        if (point->cosine > 0.4) of_ball = std::max(of_ball, std::abs(value(named) - value(all)));
      } else if (value(named) < 1e-3) {
        of_plate += value(named);
        plate += value(all);
      }
    }
  EXPECT_LT(of_ball, 0.05);
  EXPECT_GT(plate, 20.0);
  EXPECT_LT(of_plate, 0.01 * plate);
  request.reflectors = {"mat"};
  EXPECT_THROW(renderer_.render(request), Error);
  request.reflectors = {"ball"};
  request.reflections = "bezier";
  EXPECT_THROW(renderer_.render(request), Error);
}

/// While nothing moves the hits' light is averaged over frames.
TEST_P(Glossy, NoiseFallsWhileNothingMoves) {
  const auto wall = [](int) { return test::matte(glm::vec3(0.6f)); };
  set(room_with_sphere(5, wall, metal(glm::vec3(0.9f), 0.1f)), test::constant_sky(1.0f));
  FrameRequest request = glossy_request(GetParam(), "0.3");
  request.settings.set_from_text("reflections.samples", "4");
  const auto difference = [&](int frames) {
    request.seed = 1;
    const Image a = draw(request, frames).picture;
    request.seed = 2;
    const Image b = draw(request, frames).picture;
    double sum = 0.0;
    for (int y = 0; y < request.height; ++y)
      for (int x = 0; x < request.width; ++x) {
        const auto point = trace_pixel(request, x, y);
        if (!point || point->cosine < 0.4) continue;
        const double d = static_cast<double>(a.at(x, y, 1) - b.at(x, y, 1));
        sum += d * d;
      }
    return std::sqrt(sum);
  };
  const double one = difference(1), many = difference(16);
  EXPECT_GT(one, 0.0);
  EXPECT_LT(many, 0.45 * one);
}

/// At rest an exact technique's rays vary over the lobe: the corner of two walls, sharp in the first frame, blurs.
TEST_P(Glossy, LobesBlurAtRest) {
  if (GetParam().second == "octree") return;  // its cones are as wide as the lobe in every frame
  const auto wall = [](int k) { return unlit(k == 0 ? glm::vec3(0.05f) : glm::vec3(1.0f)); };
  set(room_with_sphere(6, wall, metal(glm::vec3(1.0f), 0.3f)), test::constant_sky(1.0f));
  const FrameRequest request = glossy_request(GetParam(), "0.3");
  const auto steepest = [&](const Image& image) {
    float step = 0.0f;
    for (int y = 1; y < request.height; ++y)
      for (int x = 0; x < request.width; ++x) {
        const auto above = trace_pixel(request, x, y - 1), below = trace_pixel(request, x, y);
        if (above && below && above->cosine > 0.5 && below->cosine > 0.5)
          step = std::max(step, std::abs(image.at(x, y, 1) - image.at(x, y - 1, 1)));
      }
    return step;
  };
  const float sharp = steepest(draw(request).picture), blurred = steepest(draw(request, 64).picture);
  EXPECT_GT(sharp, 0.6f);
  EXPECT_LT(blurred, 0.5f * sharp);
}

}  // namespace
