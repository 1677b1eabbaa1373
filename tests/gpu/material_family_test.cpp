// A generated family of small scenes: materials by textures by alpha by lights by UV sets. Modes that sample agree with
// the path tracer's direct transport within noise: the scene as it was made in `reference`, and as it comes back from a
// file, plain or compressed, in the others. `scripts/test --all` draws three times as many,
// MAQUETTE_FAMILY=COUNT[,SEED] any.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>

#include "render/gl/context.h"
#include "render/renderer.h"
#include "tests/support/compressed_glb.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

constexpr int kSide = 24, kBlocks = 3;

/// Draws the members of the family.
class Generator {
 public:
  explicit Generator(unsigned seed) : checkers_(seed % 5 == 4), random_(seed) {}

  Scene scene() {
    Scene scene;
    scene.materials = {material(&scene), test::matte({0.2f, 0.5f, 0.3f})};
    // A tilted quad, its corners different in everything, before a matte wall.
    const float tilt = number(-0.6f, 0.6f);
    Primitive quad = test::make_grid({-1.5f, -1.5f, -tilt}, {3, 0, 2 * tilt}, {0, 3, number(-0.6f, 0.6f)}, 1, 0);
    for (int set = 0; set < 2; ++set)
      for (const glm::vec2& corner : {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(0, 1), glm::vec2(1, 1)})
        quad.uvs[static_cast<std::size_t>(set)].push_back(corner * number(0.7f, 1.0f) + glm::vec2(number(0.0f, 0.3f)));
    if (chance(0.3f))
      for (int k = 0; k < 4; ++k) quad.colors.push_back({number(), number(), number(), number(0.6f, 1.0f)});
    test::add(&scene, std::move(quad));
    test::add(&scene, test::make_grid({-9, -9, -3}, {18, 0, 0}, {0, 18, 0}, 1, 1));
    if (chance(0.5f)) add_light(&scene);
    return scene;
  }

  CameraView camera() {
    CameraView view;
    view.eye = {number(-0.3f, 0.3f), number(-0.3f, 0.3f), 4.0f};
    view.target = glm::vec3(0.0f);
    view.fov_y_rad = 0.5f;
    if (chance(0.3f)) view.height_m = 2.0f;
    return view;
  }

  std::shared_ptr<Environment> sky() {
    return chance(0.25f)
               ? test::constant_sky(glm::vec3(number(), number(), number()))
               : test::sky_with_lamp({number(0.2f, 1.0f), number(0.2f, 1.0f), number(0.2f, 1.0f)}, glm::vec3(20.0f));
  }

 private:
  float number(float low = 0.0f, float high = 1.0f) {
    return std::uniform_real_distribution<float>(low, high)(random_);
  }
  bool chance(float p) { return number() < p; }

  /// Smooth, so that filters of different footprints agree. `normal`: nearly flat.
  TextureRef texture(Scene* scene, float probability, bool normal = false) {
    TextureRef ref;
    if (!chance(probability)) return ref;
    TextureImage image;
    image.width = 2 + static_cast<int>(number(0.0f, 3.0f));
    image.height = 2 + static_cast<int>(number(0.0f, 3.0f));
    const auto byte = [](float v) { return static_cast<std::uint8_t>(v * 255.0f + 0.5f); };
    for (int i = 0; i < image.width * image.height; ++i) {
      if (normal)
        image.rgba.insert(image.rgba.end(), {byte(number(0.4f, 0.6f)), byte(number(0.4f, 0.6f)), 255, 255});
      else
        image.rgba.insert(image.rgba.end(), {byte(number(0.3f, 1.0f)), byte(number(0.3f, 1.0f)),
                                             byte(number(0.3f, 1.0f)), byte(number(0.4f, 1.0f))});
    }
    ref.image = static_cast<int>(scene->images.size());
    scene->images.push_back(std::move(image));
    ref.uv_set = chance(0.5f) ? 1 : 0;
    if (chance(0.5f)) {
      ref.scale = {number(0.5f, 1.0f), number(0.5f, 1.0f)};
      ref.offset = {number(-0.5f, 0.5f), number(-0.5f, 0.5f)};
      ref.rotation_rad = number(-3.0f, 3.0f);
    }
    ref.wrap_s = static_cast<Wrap>(static_cast<int>(number(0.0f, 2.99f)));
    return ref;
  }

  /// Of moderate contrast: what the prediction of bandwidth must not take for uniform.
  static TextureRef roughness_checkers(Scene* scene) {
    TextureImage image;
    image.width = image.height = 4;
    for (int i = 0; i < 16; ++i) {
      const std::uint8_t roughness = (i + i / 4) % 2 ? 220 : 130;
      image.rgba.insert(image.rgba.end(), {255, roughness, 255, 255});
    }
    TextureRef ref;
    ref.image = static_cast<int>(scene->images.size());
    scene->images.push_back(std::move(image));
    return ref;
  }

  Material material(Scene* scene) {
    Material m;
    m.name = "tried";
    m.base_color = {number(0.1f, 1.0f), number(0.1f, 1.0f), number(0.1f, 1.0f), 1.0f};
    m.metallic = chance(0.5f) ? 0.0f : number();
    m.roughness = number(0.25f, 1.0f);
    m.double_sided = true;
    m.unlit = chance(0.08f);
    if (chance(0.2f)) m.emissive = glm::vec3(number(), number(), number());
    m.base_color_texture = texture(scene, 0.5f);
    m.metallic_roughness_texture = texture(scene, 0.4f);
    if (checkers_) m.metallic_roughness_texture = roughness_checkers(scene);
    m.normal_texture = texture(scene, 0.3f, true);
    m.emissive_texture = texture(scene, 0.3f);
    m.occlusion_texture = texture(scene, 0.4f);
    m.occlusion_strength = number();
    if (chance(0.35f)) m.ior = number(1.2f, 2.0f);
    if (chance(0.35f)) {
      m.specular = number();
      m.specular_color = {number(), number(), number()};
      m.specular_texture = texture(scene, 0.5f);
      m.specular_color_texture = texture(scene, 0.5f);
    }
    if (chance(0.35f)) add_coat(scene, &m);
    if (chance(0.25f)) {
      m.sheen_color = {number(), number(), number()};
      m.sheen_roughness = number(0.3f, 1.0f);
      m.sheen_color_texture = texture(scene, 0.5f);
      m.sheen_roughness_texture = texture(scene, 0.5f);
    }
    if (chance(0.25f)) {
      m.anisotropy = number();
      m.anisotropy_rotation_rad = number(-3.0f, 3.0f);
      m.anisotropy_texture = texture(scene, 0.4f);
    }
    if (chance(0.25f)) {
      m.iridescence = number();
      m.iridescence_ior = number(1.1f, 2.0f);
      m.iridescence_greatest_nm = number(150.0f, 700.0f);
      m.iridescence_texture = texture(scene, 0.5f);
      m.iridescence_thickness_texture = texture(scene, 0.5f);
    }
    add_transparency(scene, &m);
    return m;
  }

  void add_coat(Scene* scene, Material* m) {
    m->clearcoat = number();
    m->clearcoat_roughness = number(0.25f, 1.0f);
    m->clearcoat_texture = texture(scene, 0.5f);
    m->clearcoat_roughness_texture = texture(scene, 0.5f);
    m->clearcoat_normal_texture = texture(scene, 0.4f, true);
  }

  void add_transparency(Scene* scene, Material* m) {
    const float kind = number();
    if (kind < 0.15f) {
      m->alpha_mode = AlphaMode::mask;
      m->base_color.a = number(0.3f, 1.0f);
      m->alpha_cutoff = number(0.2f, 0.6f);
    } else if (kind < 0.35f) {
      m->alpha_mode = AlphaMode::blend;
      m->base_color.a = chance(0.3f) ? 1.0f : number();
    } else if (kind < 0.5f) {
      if (chance(0.3f)) {
        m->alpha_mode = AlphaMode::mask;
        m->base_color.a = number(0.3f, 1.0f);
        m->alpha_cutoff = number(0.2f, 0.6f);
      }
      if (chance(0.6f)) {
        m->metallic = 0.0f;
        m->metallic_roughness_texture = {};
      }
      m->transmission = number();
      m->glass = true;
      m->transmission_texture = texture(scene, 0.5f);
      m->thickness = chance(0.5f) ? number(0.0f, 0.2f) : 0.0f;
      m->attenuation_color = {number(0.1f, 1.0f), number(0.1f, 1.0f), number(0.1f, 1.0f)};
      m->attenuation_distance = number(0.1f, 1.0f);
      m->thickness_texture = texture(scene, 0.4f);
    }
  }

  void add_light(Scene* scene) {
    PunctualLight light;
    light.kind = static_cast<PunctualLight::Kind>(static_cast<int>(number(0.0f, 2.99f)));
    light.color = {number(), number(), number()};
    light.intensity = light.kind == PunctualLight::Kind::directional ? 3.0f : 20.0f;
    light.inner_cone_rad = number(0.0f, 0.4f);
    light.outer_cone_rad = number(0.5f, 1.2f);
    Node node;
    node.local = glm::mat4(1.0f);
    node.local[3] = {number(-1.0f, 1.0f), number(-1.0f, 1.0f), 3.0f, 1.0f};
    node.light = static_cast<int>(scene->lights.size());
    scene->roots.push_back(static_cast<int>(scene->nodes.size()));
    scene->nodes.push_back(node);
    scene->lights.push_back(light);
  }

  bool checkers_;  ///< the roughness is a texture of checkers
  std::mt19937 random_;
};

using Means = std::array<glm::dvec3, kBlocks * kBlocks>;

/// One member of the family.
struct Member {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<Environment> sky;
  CameraView camera;
};

/// From a file as its JSON and bytes, or with one of the codecs.
std::shared_ptr<const Scene> reloaded(const Scene& scene, unsigned seed) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "maquette-family";
  std::filesystem::create_directories(folder);
  const std::string path = (folder / (std::to_string(seed) + ".glb")).string();
  save_glb(path, scene);
  if (seed % 3 == 1) test::compress_glb(path, test::MeshCodec::draco);
  if (seed % 3 == 2) test::compress_glb(path, test::MeshCodec::meshopt);
  auto loaded = std::make_shared<const Scene>(load_gltf(path));
  std::filesystem::remove(path);
  for (const std::string& line : loaded->warnings)
    EXPECT_NE(line.find("the share that transmits is drawn"), std::string::npos) << line;
  return loaded;
}

Means draw(const Member& member, const std::string& mode, int samples, int frames) {
  Renderer renderer;
  renderer.set_scene(member.scene);
  renderer.set_environment(member.sky);
  FrameRequest r;
  r.mode = mode;
  r.width = r.height = kSide;
  r.samples = samples;
  r.camera = member.camera;
  r.settings.set("shading.visibility", std::string("none"));
  r.settings.set("reference.transport", std::string("direct"));
  for (int k = 0; k < frames; ++k) renderer.render(r, frames > 1);
  const Image image = renderer.read_radiance();
  Means means{};
  constexpr int kBlock = kSide / kBlocks;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      for (int c = 0; c < 3; ++c)
        means[static_cast<std::size_t>(y / kBlock * kBlocks + x / kBlock)][c] +=
            static_cast<double>(image.at(x, y, c)) / (kBlock * kBlock);
  return means;
}

std::string expect_alike(const Means& a, const Means& b, double relative) {
  double mean = 0.0, worst = 0.0;
  for (const glm::dvec3& block : b) mean += (block.x + block.y + block.z) / (3.0 * kBlocks * kBlocks);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(a[i][c] - b[i][c]) / (b[i][c] + 0.5 * mean + 1e-6));
  char text[64];
  std::snprintf(text, sizeof text, "%.4f", worst);
  return worst <= relative ? "" : text;
}

/// What a failure is of.
std::string describe(const Member& member) {
  const Scene& scene = *member.scene;
  const Material& m = scene.materials[0];
  std::string text;
  const auto add = [&](const char* name, bool on) { text += on ? std::string(" ") + name : ""; };
  add("mask", m.alpha_mode == AlphaMode::mask);
  add("blend", m.alpha_mode == AlphaMode::blend);
  add("glass", m.glass);
  add("unlit", m.unlit);
  add("normal", static_cast<bool>(m.normal_texture));
  add("occlusion", static_cast<bool>(m.occlusion_texture));
  add("coat", m.clearcoat > 0.0f);
  add("coat-normal", static_cast<bool>(m.clearcoat_normal_texture));
  add("sheen", m.sheen_color != glm::vec3(0.0f));
  add("anisotropy", m.anisotropy > 0.0f);
  add("film", m.iridescence > 0.0f);
  add("colours", !scene.meshes[0].primitives[0].colors.empty());
  add("rough-texture", static_cast<bool>(m.metallic_roughness_texture));
  add("light", !scene.lights.empty());
  add("orthographic", member.camera.is_orthographic());
  return text;
}

TEST(MaterialFamily, ModesAgreeWithTheReference) {
  int count = std::getenv("MAQUETTE_ALL_TESTS") ? 30 : 10;
  unsigned first = 1;
  if (const char* asked = std::getenv("MAQUETTE_FAMILY")) std::sscanf(asked, "%d,%u", &count, &first);
  const GlContext context = GlContext::create_headless();
  for (int k = 0; k < count; ++k) {
    const unsigned seed = first + static_cast<unsigned>(k);
    Generator generator(seed);
    Member member{std::make_shared<const Scene>(generator.scene()), generator.sky(), generator.camera()};
    const Means reference = draw(member, "reference", 400, 1);
    member.scene = reloaded(*member.scene, seed);
    EXPECT_EQ(expect_alike(draw(member, "uniform", 1024, 1), reference, 0.03), "")
        << "uniform, seed " << seed << describe(member);
    EXPECT_EQ(expect_alike(draw(member, "bandwidth", 1024, 2), reference, 0.03), "")
        << "bandwidth, seed " << seed << describe(member);
  }
  const std::vector<std::string> errors = take_gl_errors();
  EXPECT_TRUE(errors.empty()) << errors.front();
}

}  // namespace
}  // namespace maquette
