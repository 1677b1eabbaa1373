// What mirrors show of surfaces that blend and that glow.
#include "render/math/shared_formulas.h"
#include "tests/gpu/reflections_fixture.h"

namespace maquette::test {
namespace {

constexpr int kWidth = 192, kHeight = 128;
constexpr glm::vec3 kWall{3.0f, 2.0f, 1.0f};

Material glowing(const std::string& name, const glm::vec3& emission) {
  Material m = plain(name, glm::vec3(0.0f));
  m.emissive = emission;
  return m;
}

Primitive with_uvs(Primitive grid, int side) {
  for (int j = 0; j <= side; ++j)
    for (int i = 0; i <= side; ++i)
      grid.uvs[0].push_back(
          {static_cast<float>(i) / static_cast<float>(side), static_cast<float>(j) / static_cast<float>(side)});
  return grid;
}

/// Two texels side by side, not filtered: white, with an alpha each.
TextureRef two_texels(Scene* scene, std::uint8_t left, std::uint8_t right) {
  TextureImage image;
  image.width = 2;
  image.height = 1;
  image.rgba = {255, 255, 255, left, 255, 255, 255, right};
  scene->images.push_back(image);
  TextureRef ref;
  ref.image = static_cast<int>(scene->images.size()) - 1;
  ref.wrap_s = ref.wrap_t = Wrap::clamp_to_edge;
  ref.nearest = true;
  return ref;
}

/// A mirror at z = -1 that faces a glowing wall at z = 3; the eye stands between.
Scene facing_wall() {
  Scene scene;
  scene.materials = {glowing("wall", kWall), plain("layer", glm::vec3(0.5f)), plain("other", glm::vec3(0.5f)),
                     mirror_metal()};
  add(&scene, make_grid({-4.0f, -4.0f, 3.0f}, {0, 8, 0}, {8, 0, 0}, 8, 0), "wall");
  add_patch(&scene, 0.0f);
  scene.patches[0].reflector = true;
  return scene;
}

/// A square of 3 m beside the axis at depth z, facing the mirror.
void add_layer(Scene* scene, float z, int material) {
  constexpr int kSide = 6;
  add(scene, with_uvs(make_grid({-1.5f, -1.5f, z}, {3, 0, 0}, {0, 3, 0}, kSide, material), kSide), "layer");
}

/// Where the mirrored ray of a pixel crosses depth z.
glm::vec2 mirrored_at(int x, int y, float z) {
  const float half = std::tan(0.25f), eye_z = 1.8f, mirror_z = -1.0f;
  const glm::vec2 d{(2.0f * (static_cast<float>(x) + 0.5f) / kWidth - 1.0f) * half * kWidth / kHeight,
                    (1.0f - 2.0f * (static_cast<float>(y) + 0.5f) / kHeight) * half};
  return d * (eye_z - mirror_z + z - mirror_z);
}

class MirroredBlended : public ::testing::Test {
 protected:
  static FrameRequest request(const std::string& technique, const std::string& mode = "uniform") {
    FrameRequest r = request_of(technique);
    r.width = kWidth;
    r.height = kHeight;
    r.reflectors = {"mirror"};
    r.mode = mode;
    r.camera.eye = {0.0f, 0.0f, 1.8f};
    r.camera.target = {0.0f, 0.0f, -1.0f};
    r.settings.set_from_text("shading.visibility", "none");
    r.settings.set_from_text("shading.indirect", "none");
    return r;
  }
  Image reflection(const Scene& scene, const FrameRequest& r, float sky = 0.0f) {
    renderer_.set_scene(std::make_shared<Scene>(scene));
    renderer_.set_environment(constant_sky(sky));
    return draw_reflection(&renderer_, r);
  }
  Image picture(const Scene& scene, const FrameRequest& r) {
    renderer_.set_scene(std::make_shared<Scene>(scene));
    renderer_.set_environment(constant_sky(0.0f));
    EXPECT_TRUE(renderer_.finish_background_work(r));
    renderer_.render(r);
    return renderer_.read_radiance();
  }

  GlContext context_ = GlContext::create_headless();
  Renderer renderer_;
};

/// Alpha is factor times texture times vertex alpha, in every technique; behind it the wall shows.
TEST_F(MirroredBlended, AddTheirAlphaOfWhatTheyShow) {
  Scene scene = facing_wall();
  Material& m = scene.materials[1];
  m.unlit = true;
  m.base_color = {0.2f, 0.4f, 0.8f, 0.8f};
  m.alpha_mode = AlphaMode::blend;
  m.base_color_texture = two_texels(&scene, 255, 102);
  add_layer(&scene, 2.5f, 1);
  Primitive& layer = scene.meshes.back().primitives[0];
  layer.colors.assign(layer.positions.size(), {1.0f, 1.0f, 1.0f, 0.5f});
  for (const char* technique : {"raytraced", "octree", "triangle", "bezier"}) {
    const Image seen = reflection(scene, request(technique));
    int tried = 0;
    for (int y = 30; y < 98; y += 6)
      for (int x = 20; x < 172; x += 4) {
        const glm::vec2 at = mirrored_at(x, y, 2.5f);
        if (std::abs(at.x) < 0.1f || std::abs(std::abs(at.x) - 1.5f) < 0.1f || std::abs(at.y) > 1.4f) continue;
        const float alpha = std::abs(at.x) > 1.5f ? 0.0f : 0.8f * 0.5f * (at.x < 0.0f ? 1.0f : 0.4f);
        ++tried;
        for (int c : {0, 1, 2})
          ASSERT_NEAR(seen.at(x, y, c), alpha * m.base_color[c] + (1.0f - alpha) * kWall[c], 0.02f * kWall[c])
              << technique << ", " << x << ", " << y;
      }
    EXPECT_GT(tried, 100) << technique;
  }
}

/// Each of six layers dims those behind it; those behind the fourth have its look and their own alpha.
TEST_F(MirroredBlended, CoverEachOtherFromFrontToBack) {
  Scene scene = facing_wall();
  const glm::vec3 colors[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {1, 1, 0}};
  glm::vec3 expected(0.0f);
  float through = 1.0f;
  for (int k = 0; k < 5; ++k) {
    Material m = glowing("layer " + std::to_string(k), colors[k]);
    m.base_color.a = 0.3f + 0.1f * static_cast<float>(k);
    m.alpha_mode = AlphaMode::blend;
    scene.materials.push_back(m);
    // From the mirror, the nearest first.
    add_layer(&scene, 2.0f + 0.15f * static_cast<float>(k), 4 + k);
    expected += through * m.base_color.a * colors[k];
    through *= 1.0f - m.base_color.a;
  }
  expected += through * kWall;
  const Image seen = reflection(scene, request("raytraced"));
  for (int c : {0, 1, 2}) EXPECT_NEAR(seen.at(kWidth / 2, kHeight / 2, c), expected[c], 0.02f) << c;
}

/// Where alpha is 1 a blended surface looks like an opaque one under lamps and sky, and where it is 0 it is not there.
TEST_F(MirroredBlended, LookOpaqueWhereTheyCoverAll) {
  for (const char* mode : {"uniform", "splitsum"}) {
    Scene scene = facing_wall();
    scene.materials[1].roughness = 0.4f;
    scene.materials[1].base_color = {0.7f, 0.3f, 0.1f, 1.0f};
    PunctualLight lamp;
    lamp.kind = PunctualLight::Kind::point;
    lamp.intensity = 10.0f;
    Node node;
    node.local[3] = {0.5f, 0.7f, 0.5f, 1.0f};
    node.light = 0;
    scene.lights.push_back(lamp);
    scene.roots.push_back(static_cast<int>(scene.nodes.size()));
    scene.nodes.push_back(node);
    Scene bare = scene;
    add_layer(&scene, 2.5f, 1);
    Scene blended = scene;
    blended.materials[1].alpha_mode = AlphaMode::blend;
    blended.materials[1].base_color_texture = two_texels(&blended, 255, 0);
    FrameRequest r = request("raytraced", mode);
    r.settings.set_from_text("reflections.samples", "16");
    const Image whole = reflection(scene, r, 1.0f), none = reflection(bare, r, 1.0f),
                seen = reflection(blended, r, 1.0f);
    int covered = 0, open = 0;
    for (int y = 30; y < 98; y += 6)
      for (int x = 20; x < 172; x += 4) {
        const glm::vec2 at = mirrored_at(x, y, 2.5f);
        if (std::abs(at.x) < 0.1f || std::abs(at.x) > 1.4f || std::abs(at.y) > 1.4f) continue;
        const bool covers = at.x < 0.0f;
        ++(covers ? covered : open);
        for (int c : {0, 1, 2}) {
          const float expected = (covers ? whole : none).at(x, y, c);
          // A texture is filtered at the hit, where a colour is not: the rest of rounding.
          ASSERT_NEAR(seen.at(x, y, c), expected, 0.01f * expected + 1e-4f) << mode << ", " << x << ", " << y;
        }
      }
    EXPECT_GT(covered, 50);
    EXPECT_GT(open, 50);
  }
}

/// Rays pass what alpha cuts out, in the exact technique and through cells.
TEST_F(MirroredBlended, AreCutOutByAlpha) {
  Scene scene = facing_wall();
  Material& m = scene.materials[1];
  m.unlit = true;
  m.base_color = {0.2f, 0.4f, 0.8f, 0.8f};
  m.alpha_mode = AlphaMode::mask;
  m.alpha_cutoff = 0.5f;
  m.base_color_texture = two_texels(&scene, 255, 102);
  add_layer(&scene, 2.5f, 1);
  for (const char* technique : {"raytraced", "octree"}) {
    const Image seen = reflection(scene, request(technique));
    for (int y = 30; y < 98; y += 6)
      for (int x = 20; x < 172; x += 4) {
        const glm::vec2 at = mirrored_at(x, y, 2.5f);
        if (std::abs(at.x) < 0.1f || std::abs(at.x + 1.5f) < 0.1f || std::abs(at.y) > 1.4f) continue;
        const bool shown = at.x > -1.5f && at.x < 0.0f;
        for (int c : {0, 1, 2})
          ASSERT_NEAR(seen.at(x, y, c), shown ? m.base_color[c] : kWall[c], 0.02f * kWall[c])
              << technique << ", " << x << ", " << y;
      }
  }
}

/// What the eye sees of blended surfaces behind panes and each other is dimmed by these once, whatever the processor's
/// rays know of them.
TEST_F(MirroredBlended, AreDimmedOnceBehindPanes) {
  Scene scene;
  for (int k = 0; k < 2; ++k) {
    Material m = plain("unlit " + std::to_string(k), k == 0 ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0));
    m.unlit = true;
    m.base_color.a = 0.5f;
    m.alpha_mode = AlphaMode::blend;
    scene.materials.push_back(m);
    add_layer(&scene, -0.5f - 0.5f * static_cast<float>(k), k);
  }
  Material pane = clear_pane();
  pane.ior = 1.5f;
  pane.base_color = {0.5f, 0.5f, 0.5f, 1.0f};
  scene.materials.push_back(pane);
  add_layer(&scene, 0.0f, 2);
  for (const char* technique : {"off", "raytraced"}) {
    FrameRequest r = request(technique);
    r.reflectors = {};
    r.settings.set_from_text("shading.visibility", "rays");
    const Image seen = picture(scene, r);
    const float through = shared::fresnel_pane(1.0f, 1.5f, 0.5f).y;
    EXPECT_NEAR(seen.at(kWidth / 2, kHeight / 2, 0), 0.5f * through, 0.01f) << technique;
    EXPECT_NEAR(seen.at(kWidth / 2, kHeight / 2, 1), 0.25f * through, 0.01f) << technique;
  }
}

/// What a mirror shows of surfaces that glow, opaque and blended, is what paths find.
TEST_F(MirroredBlended, AndEmissiveSurfacesAreMirroredAsPathsFindThem) {
  Scene scene = facing_wall();
  scene.materials[0].emissive_texture = two_texels(&scene, 255, 255);
  scene.images.back().rgba = {255, 128, 0, 255, 64, 255, 255, 255};
  Primitive& wall = scene.meshes[0].primitives[0];
  wall = with_uvs(wall, 8);
  scene.materials[1] = glowing("layer", {0.5f, 2.0f, 4.0f});
  scene.materials[1].base_color.a = 0.6f;
  scene.materials[1].alpha_mode = AlphaMode::blend;
  add_layer(&scene, 2.5f, 1);
  scene.nodes.back().local = glm::mat4(1.0f);
  for (glm::vec3& p : scene.meshes.back().primitives[0].positions) p.x += 0.8f;
  FrameRequest exact = request("off", "reference");
  exact.samples = 64;
  exact.settings.set_from_text("reference.transport", "full");
  const Image reference = picture(scene, exact);
  for (const char* mode : {"uniform", "bandwidth"}) {
    const Image seen = picture(scene, request("raytraced", mode));
    double worst = 0.0;
    constexpr int kBlock = 16;
    for (int by = 0; by < kHeight / kBlock; ++by)
      for (int bx = 0; bx < kWidth / kBlock; ++bx)
        for (int c = 0; c < 3; ++c) {
          double a = 0.0, b = 0.0;
          for (int k = 0; k < kBlock * kBlock; ++k) {
            const int x = bx * kBlock + k % kBlock, y = by * kBlock + k / kBlock;
            a += static_cast<double>(seen.at(x, y, c)) / (kBlock * kBlock);
            b += static_cast<double>(reference.at(x, y, c)) / (kBlock * kBlock);
          }
          worst = std::max(worst, std::abs(a - b));
        }
    // cd/m2; the metal's reflectance differs by the lobe's energy and grazing angles.
    EXPECT_LT(worst, 0.04) << mode;
  }
}

}  // namespace
}  // namespace maquette::test
