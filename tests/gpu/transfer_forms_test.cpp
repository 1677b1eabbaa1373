// Precomputed transfer in its joint form, and with reflections between parts.
#include "render/prt/job.h"
#include "render/reference/reference.h"
#include "tests/gpu/transfer_fixture.h"

namespace maquette {
namespace {

class TransferForms : public TransferMode {
 protected:
  static Image traced(const Scene& scene, const std::shared_ptr<const Environment>& sky, const FrameRequest& request,
                      int bounces, int samples) {
    ReferencePicture picture(build_path_scene({.scene = scene, .environment = sky}),
                             {.camera = request.camera,
                              .width = request.width,
                              .height = request.height,
                              .paths = {.max_bounces = bounces}});
    picture.add(samples);
    return picture.mean();
  }
  /// Leaves out what a view shows nothing of.
  static void keep_parts(const Image& shown, Image* reference) {
    for (int y = 0; y < reference->height; ++y)
      for (int x = 0; x < reference->width; ++x)
        if (!(shown.at(x, y, 0) > 0.0f)) reference->at(x, y, 3) = 0.0f;
  }
  static std::shared_ptr<const Environment> smooth_sky() {
    auto sky = std::make_shared<Environment>(*test::constant_sky(1.0f));
    for (int y = 0; y < sky->height; ++y)
      for (int x = 0; x < sky->width; ++x) {
        const glm::dvec3 d = direction_from_latlong(x + 0.5, y + 0.5, sky->width, sky->height);
        sky->rgb[static_cast<std::size_t>(y * sky->width + x)] = glm::vec3(1.0 + d.x, 1.0 + 0.8 * d.z, 1.2 + d.y);
      }
    return sky;
  }
};

TEST_F(TransferForms, TheJointFormShowsWhatTheFormByViewsShows) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  const auto scene = covered_plate();
  const auto sky = smooth_sky();
  renderer.set_scene(scene);
  renderer.set_environment(sky);
  FrameRequest request = look(small_request());
  request.settings.set("prt.vertices", 600);
  request.settings.set("prt.parts", std::string("plate"));
  request.settings.set("prt.coefficients", 1024);
  request.settings.set("prt.form", std::string("views"));
  const Drawn by_views = draw(&renderer, request);
  request.settings.set("prt.form", std::string("joint"));
  request.settings.set("prt.texel_clusters", 16);
  request.settings.set("prt.joint_clusters", 4);
  const Drawn joint = draw(&renderer, request);
  EXPECT_LT(relative_difference(joint.picture, by_views.picture), 0.02);
  const Image parts = renderer.read_debug_view("prt_vertices");
  Image reference = traced(*scene, sky, request, 1, 100);
  keep_parts(parts, &reference);
  EXPECT_LT(relative_difference(joint.picture, reference), 0.06);
  // Of a smaller count of clusters fewer bytes, and more error.
  request.settings.set("prt.texel_clusters", 1);
  const Drawn coarse = draw(&renderer, request);
  EXPECT_LT(coarse.stats.technique.at("prt_vertex_bytes"), 0.2 * joint.stats.technique.at("prt_vertex_bytes"));
  EXPECT_GT(relative_difference(coarse.picture, reference), relative_difference(joint.picture, reference));
  for (const char* view : {"prt_light", "prt_component", "prt_clusters", "prt_error"}) renderer.read_debug_view(view);
  for (const auto& e : take_gl_errors()) ADD_FAILURE() << e;
}

TEST_F(TransferForms, TheLightTurnsInTheJointFormToo) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  renderer.set_scene(covered_plate());
  renderer.set_environment(test::sky_with_lamp({0.5f, 0.6f, 0.8f}, glm::vec3(60.0f)));
  FrameRequest request = look(small_request());
  request.settings.set("prt.parts", std::string("plate"));
  request.settings.set("prt.texel_clusters", 16);
  Image pictures[2][2];
  for (const int joint : {0, 1})
    for (const int turned : {0, 1}) {
      request.settings.set("prt.form", std::string(joint == 1 ? "joint" : "views"));
      request.env_rotation_rad = turned == 1 ? glm::radians(37.0f) : 0.0f;
      pictures[joint][turned] = draw(&renderer, request).picture;
    }
  EXPECT_LT(relative_difference(pictures[1][1], pictures[0][1]), 0.03);
  EXPECT_GT(relative_difference(pictures[1][0], pictures[1][1]), 0.05);
}

TEST_F(TransferForms, MirroredRaysShowTheJointForm) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  renderer.set_scene(mirrored_plate());
  renderer.set_environment(test::constant_sky(1.0f));
  FrameRequest request = look(small_request());
  request.reflections = "raytraced";
  request.settings.set("prt.parts", std::string("plate"));
  request.settings.set("prt.texel_clusters", 16);
  const Image by_views = draw(&renderer, request).picture;
  request.settings.set("prt.form", std::string("joint"));
  const Image joint = draw(&renderer, request).picture;
  EXPECT_LT(relative_difference(joint, by_views), 0.03);
  EXPECT_TRUE(take_gl_errors().empty());
}

TEST_F(TransferForms, ThePlanSaysWhichFormAndWhy) {
  const auto facts = [](std::size_t triangles, bool has_btf = false) {
    SceneFacts found;
    found.triangle_count = triangles;
    found.has_btf = has_btf;
    return found;
  };
  Settings settings;
  EXPECT_FALSE(choose_transfer_form(settings, facts(40000)).joint);
  EXPECT_NE(choose_transfer_form(settings, facts(40000)).reason.find("20000 vertices"), std::string::npos);
  EXPECT_TRUE(choose_transfer_form(settings, facts(400000)).joint);
  EXPECT_NE(choose_transfer_form(settings, facts(400000)).reason.find("more than 256"), std::string::npos);
  // Materials without a BTF never get many components.
  EXPECT_FALSE(choose_transfer_form(settings, facts(100000)).joint);
  EXPECT_TRUE(choose_transfer_form(settings, facts(100000, true)).joint);
  settings.set("prt.vertices", 200000);
  EXPECT_TRUE(choose_transfer_form(settings, facts(100)).joint);
  settings.set("prt.form", std::string("views"));
  EXPECT_FALSE(choose_transfer_form(settings, facts(400000)).joint);
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  renderer.set_scene(covered_plate());
  renderer.set_environment(test::constant_sky(1.0f));
  FrameRequest request = look(small_request());
  request.settings.set("prt.form", std::string("joint"));
  bool told = false;
  for (const PlannedPass& pass : draw(&renderer, request).stats.plan.passes)
    told = told ||
           (pass.name == "transfer_vertices" && pass.reason.find("joint form: prt.form=joint") != std::string::npos);
  EXPECT_TRUE(told);
}

/// A floor and two walls of unlike colours in a corner: light goes to and fro.
TEST_F(TransferForms, ReflectionsAgreeWithTheReference) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  auto scene = std::make_shared<Scene>();
  for (const glm::vec3& albedo : {glm::vec3(0.8f), glm::vec3(0.8f, 0.2f, 0.1f), glm::vec3(0.2f, 0.7f, 0.8f)}) {
    scene->materials.push_back(test::matte(albedo));
    scene->materials.back().name = "matte " + std::to_string(scene->materials.size());
  }
  test::add(scene.get(), test::make_grid({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 8, 0), "floor");
  test::add(scene.get(), test::make_grid({-1, 0, -1}, {2, 0, 0}, {0, 1.5f, 0}, 8, 1), "back");
  test::add(scene.get(), test::make_grid({-1, 0, 1}, {0, 0, -2}, {0, 1.5f, 0}, 8, 2), "side");
  const auto sky = smooth_sky();
  renderer.set_scene(scene);
  renderer.set_environment(sky);
  FrameRequest request = look(small_request());
  request.camera.eye = {1.9f, 1.4f, 2.2f};
  request.settings.set("prt.faces", 8);
  request.settings.set("prt.clusters", 8);
  request.settings.set("prt.coefficients", 1024);
  request.settings.set("prt.btf_components", 0);  // matte surfaces have none
  const Image direct = draw(&renderer, request).picture;
  for (const std::string form : {"views", "joint"}) {
    request.settings.set("prt.form", form);
    request.settings.set("prt.bounces", 3);
    const Image reflected = draw(&renderer, request).picture;
    const Image reference = traced(*scene, sky, request, 4, 200);
    EXPECT_LT(relative_difference(reflected, reference), 0.05) << form;
    EXPECT_GT(relative_difference(direct, reference), 0.2) << form;
  }
}

}  // namespace
}  // namespace maquette
