#include "render/technique/registry.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "render/bake/bake_runner.h"
#include "render/bake/scene_bake.h"
#include "render/gl/context.h"
#include "render/renderer.h"
#include "render/shading/shading_mode.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

std::shared_ptr<Scene> scene_with_a_mirror() {
  auto scene = std::make_shared<Scene>(test::box_scene(5, 4, test::matte({0.6f, 0.4f, 0.3f})));
  Material chrome;
  chrome.name = "chrome";
  chrome.metallic = 1.0f;
  chrome.roughness = 0.0f;
  scene->materials.push_back(chrome);
  test::add(scene.get(), test::make_grid({-0.5f, -0.5f, -0.5f}, {1, 0, 0}, {0, 1, 0}, 2, 1), "mirror")->reflector =
      true;
  return scene;
}

FrameRequest request_for(const std::string& mode, const std::string& reflections) {
  FrameRequest r;
  r.mode = mode;
  r.reflections = reflections;
  r.width = 64;
  r.height = 48;
  r.samples = 8;
  r.camera.eye = {0.2f, 0.1f, 0.9f};
  r.camera.target = {0.0f, 0.0f, -1.0f};
  r.settings.set("shading.visibility", std::string("none"));
  r.settings.set("octree.depth", 6);
  r.settings.set("slf.texels", 16);
  r.settings.set("slf.paths", 1);
  return r;
}

struct Drawn {
  Image picture;
  FrameStats stats;
};
Drawn draw(const Registry& registry, const std::string& mode, const std::string& reflections) {
  Renderer renderer(registry);
  renderer.set_scene(scene_with_a_mirror());
  renderer.set_environment(test::constant_sky(glm::vec3(1.0f)));
  const FrameRequest request = request_for(mode, reflections);
  EXPECT_TRUE(renderer.finish_background_work(request));
  Drawn drawn;
  drawn.stats = renderer.render(request);
  drawn.picture = renderer.read_radiance();
  return drawn;
}

/// Nothing outside a technique's folder may depend on what it is called.
TEST(Registry, NamesOfTechniquesAreOnlyNames) {
  const GlContext context = GlContext::create_headless();
  const Registry& own = builtin_registry();
  Registry renamed = own;
  for (Technique& technique : renamed.techniques) technique.name = "renamed-" + technique.name;
  renamed.default_mode = "renamed-" + own.default_mode;
  std::vector<std::pair<std::string, std::string>> cases;
  for (const std::string& mode : own.names(TechniqueKind::mode)) cases.emplace_back(mode, kNoReflections);
  for (const std::string& reflector : own.names(TechniqueKind::reflector)) cases.emplace_back("uniform", reflector);
  for (const auto& [mode, reflections] : cases) {
    SCOPED_TRACE(mode + " " + reflections);
    const Drawn before = draw(own, mode, reflections);
    const Drawn after =
        draw(renamed, "renamed-" + mode, reflections == kNoReflections ? reflections : "renamed-" + reflections);
    EXPECT_EQ(before.picture.data, after.picture.data);
    ASSERT_EQ(before.stats.plan.passes.size(), after.stats.plan.passes.size());
    for (std::size_t i = 0; i < before.stats.plan.passes.size(); ++i)
      EXPECT_EQ(before.stats.plan.passes[i].name, after.stats.plan.passes[i].name);
    EXPECT_EQ(before.stats.plan.left_out.size(), after.stats.plan.left_out.size());
    for (const auto& [what, bytes] : before.stats.gpu_bytes) EXPECT_EQ(after.stats.gpu_bytes.count(what), 1u) << what;
  }
  EXPECT_TRUE(take_gl_errors().empty());
}

/// A bake of the test's own: counts the triangles of the scene, on its own thread.
struct CountKind : BakeKind<std::size_t, std::size_t> {
  Baked<std::size_t> run(const std::size_t& indices, const Baked<std::size_t>&, const BakeTask<std::size_t>&) override {
    return {std::make_shared<const std::size_t>(indices / 3), true};
  }
};
class CountBake final : public KeyedBake<Key, std::size_t, std::size_t>, public SceneBake {
 public:
  CountBake() : KeyedBake(std::make_shared<CountKind>()) {}
  const char* name() const override { return "triangle_count"; }
  Bake& bake() override { return *this; }
  bool update(const SceneState& scene, const FrameRequest&, const ShadingPlan&) override {
    require(Key::of(scene.revisions().geometry), [&] { return scene.geometry().indices.size(); });
    const std::shared_ptr<const std::size_t> count = take();
    if (!count) return false;
    const float value = static_cast<float>(*count);
    texture_ = Texture::make_2d("triangle count", GL_R32F, 1, 1);
    texture_.upload(0, 1, 1, GL_RED, GL_FLOAT, &value);
    return true;
  }
  void bind() const override { glBindTextureUnit(40, texture_.get()); }
  bool ready() const override { return texture_.get() != 0; }
  std::size_t bytes() const override { return texture_.bytes(); }

 private:
  Texture texture_;
};

/// A mode of the test's own: what is seen is as bright as its number of triangles says.
class TriangleMode : public ShadingMode {
 public:
  explicit TriangleMode(std::string shader) : shader_(std::move(shader)) {}
  int band_rows(const GridSize& size) const override { return (size.grid_height() + 31) / 32 * 32; }
  void fit(const GridSize&) override {}
  void set_constants(const FrameStart&, const ShadingPlan&, FrameConstants*) const override {}
  std::vector<Pass> passes(const LayerContext& layer) override {
    return {{.names = {"count"}, .layer = layer.index, .run = [this, &layer] {
               glBindImageTexture(0, layer.radiance.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
               dispatch_tiles(layer.frame.programs.get({shader_, "", {}}), layer.surfaces.tiles(), kPerPoint);
             }}};
  }
  void shade_hits(const HitShading&) override {}
  ShadingCounts counts() const override { return {}; }
  std::optional<PointValue> view(const std::string& name, const LayerContext&) const override {
    if (name != "seven") return std::nullopt;
    return [](int, int) { return glm::vec3(7.0f); };
  }

 private:
  std::string shader_;
};

TEST(Registry, ATechniqueOfOnesOwnDrawsWithoutALineInTheProduct) {
  const GlContext context = GlContext::create_headless();
  const std::filesystem::path shader = std::filesystem::path(::testing::TempDir()) / "count.comp";
  std::ofstream(shader) << R"(layout(local_size_x = 64) in;
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
layout(binding = 0) uniform usampler2D t_triangle;
layout(binding = 40) uniform sampler2D t_count;
layout(binding = 0, rgba32f) uniform writeonly image2D o_radiance;
void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  imageStore(o_radiance, pixel, vec4(float(texelFetch(t_triangle, pixel, 0).x), texelFetch(t_count, ivec2(0), 0).x, 0.0, 1.0));
}
)";
  Registry registry = builtin_registry();
  Technique own;
  own.name = "triangles";
  own.make_mode = [&] { return std::make_unique<TriangleMode>(shader.string()); };
  own.add_passes = [](const PlanInput&, ShadingPlan*, FramePlan* plan) {
    plan->passes.push_back({"count", "the number of the triangle that is seen", {"triangles"}, {"radiance"}});
  };
  own.shader_variants = [&] { return std::vector<ShaderVariant>{{shader.string(), "", {}}}; };
  own.views = {{"seven", "always seven"}};
  own.own_bake = OwnBake{"triangle_count", "how many there are", [] { return std::make_unique<CountBake>(); }};
  bool baked = false;
  own.bakes = {{"triangles", "nothing much", [&](const BakeRequest&, const BakeControl&) { baked = true; }}};
  registry.techniques.push_back(own);

  Renderer renderer(registry);
  auto scene = std::make_shared<Scene>();
  scene->materials.push_back(test::matte(glm::vec3(0.5f)));
  test::add(scene.get(), test::make_grid({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 1, 0), "sheet");
  renderer.set_scene(scene);
  renderer.set_environment(test::constant_sky(glm::vec3(0.0f)));
  FrameRequest request = request_for("triangles", kNoReflections);
  request.camera.eye = {0.0f, 0.0f, 1.0f};
  request.camera.target = {0.0f, 0.0f, 0.0f};
  EXPECT_TRUE(renderer.finish_background_work(request));
  const FrameStats stats = renderer.render(request);
  EXPECT_EQ(stats.plan.shading().own_bake, "triangle_count");
  EXPECT_EQ(stats.gpu_bytes.at("triangle_count"), 4u);
  const Image picture = renderer.read_radiance();
  EXPECT_EQ(picture.at(60, 40, 1), 2.0f) << "of the bake";
  EXPECT_EQ(picture.at(60, 40, 0), 1.0f) << "below the diagonal";
  EXPECT_EQ(picture.at(4, 4, 0), 2.0f) << "above it";
  EXPECT_EQ(renderer.read_debug_view("seven").at(32, 24, 1), 7.0f);
  const auto variants = all_shader_variants(registry);
  EXPECT_TRUE(
      std::any_of(variants.begin(), variants.end(), [&](const ShaderVariant& v) { return v.path == shader.string(); }));
  const Settings settings;
  const std::atomic<bool> cancel{false};
  registry.find_bake("triangles").run({*scene, -1, settings, {}, ""}, {cancel, {}, {}});
  EXPECT_TRUE(baked);
  EXPECT_TRUE(take_gl_errors().empty());
}

}  // namespace
}  // namespace maquette
