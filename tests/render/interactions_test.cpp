// The second route of light fields: light and material compressed apart, against outgoing light that is stored.
#include "render/slf/interactions.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <glm/gtc/packing.hpp>
#include <random>

#include "render/reference/path_scene.h"
#include "scenes/btf/btf_file.h"
#include "scenes/error.h"
#include "tests/support/never.h"
#include "tests/support/small_btf.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

/// A sheet whose tangents lie at 0.4 rad to the world's axes, and its light: a lobe that wanders over the texels.
struct Sheet {
  std::shared_ptr<const PathScene> scene;
  LightFieldAtlas atlas;
  IncidentField incident;
};
Sheet sheet_of(const Material& material, float angle, int side) {
  Scene scene;
  scene.materials.push_back(material);
  const glm::vec3 x(std::cos(angle), std::sin(angle), 0.0f), y(-x.y, x.x, 0.0f);
  Primitive quad = test::make_grid(-x - y, 2.0f * x, 2.0f * y, 1, 0);
  quad.uvs[0] = {{0.0f, 0.0f}, {1.0f, 0.0f}, {0.0f, 1.0f}, {1.0f, 1.0f}};
  test::add(&scene, quad, "sheet");
  Sheet sheet;
  sheet.scene = build_path_scene({.scene = scene, .environment = test::constant_sky(0.0f)});
  sheet.atlas = make_atlas(sheet.scene->geometry, {{0, false}}, {.side = side});
  const Lumisphere sphere;
  sheet.incident.bins = sphere.count();
  sheet.incident.masked.assign(sheet.atlas.texels.size(), false);
  for (std::size_t t = 0; t < sheet.atlas.texels.size(); ++t) {
    const float at = 0.02f * static_cast<float>(t);
    const glm::vec3 lamp = glm::normalize(glm::vec3(std::cos(at), std::sin(at), 0.6f + 0.4f * std::sin(0.3f * at)));
    for (int b = 0; b < sphere.count(); ++b) {
      const float lobe = std::exp((glm::dot(lamp, sphere.direction(b)) - 1.0f) * 8.0f);
      for (const float tone : {1.0f, 0.8f, 0.5f}) sheet.incident.radiance.push_back(0.2f + tone * lobe);
    }
  }
  return sheet;
}

double error_of(const Sheet& sheet, const InteractionOptions& options) {
  const auto stored = compute_outgoing(*sheet.scene, sheet.atlas, sheet.incident, {.basis = LightBasis::bins}, kNever);
  const auto terms = compress_interactions(*sheet.scene, sheet.atlas, sheet.incident, options, kNever);
  const auto apart = compute_interactions(*terms, kNever);
  if (apart->codes.light_terms > 1) {
    EXPECT_LE(apart->codes.light_weights.cwiseAbs().maxCoeff(), 1.0f);
  }
  EXPECT_LE(apart->codes.material_weights.cwiseAbs().maxCoeff(), 1.0f);
  EXPECT_LE(static_cast<std::size_t>(apart->table.cols()) * 256 * 8, options.most_bytes);
  return interaction_error(*apart, *stored, sheet.incident.side, 3);
}

Material covered_with(const std::string& file) {
  Material m;
  m.measured = file;
  return m;
}

TEST(Interactions, OfEnoughTermsAreWhatIsStored) {
  const std::string file = (std::filesystem::path(testing::TempDir()) / "interactions-btf.exr").string();
  save_btf(file, *test::small_btf(3, 4));
  // The light wanders in few dimensions and the BTF has nine texels: so many terms hold both.
  const InteractionOptions many{.counts = InteractionCounts{48, 4, 4}};
  EXPECT_LT(error_of(sheet_of(covered_with(file), 0.0f, 12), many), 0.005);
  EXPECT_LT(error_of(sheet_of(covered_with(file), 0.4f, 12), many), 0.02);  // light is read at turned directions
  Material gloss;
  gloss.roughness = std::sqrt(0.5f);
  gloss.metallic = 1.0f;
  EXPECT_LT(error_of(sheet_of(gloss, 0.4f, 12), many), 0.005);
  EXPECT_LT(error_of(sheet_of(test::matte(glm::vec3(0.5f, 0.3f, 0.2f)), 0.4f, 12), many), 0.005);
  std::filesystem::remove(file);
}

TEST(Interactions, OfFewTermsAreWorseAndFitTheirTable) {
  const std::string file = (std::filesystem::path(testing::TempDir()) / "interactions-few.exr").string();
  save_btf(file, *test::small_btf(3, 4));
  const Sheet sheet = sheet_of(covered_with(file), 0.0f, 12);
  const double few = error_of(sheet, {.counts = InteractionCounts{2, 0, 0}}),
               more = error_of(sheet, {.counts = InteractionCounts{8, 2, 2}});
  EXPECT_GT(few, more);
  EXPECT_GT(few, 0.02);
  // Room for two clusters of light with three of the material.
  EXPECT_LT(error_of(sheet, {.counts = InteractionCounts{2, 2, 2}, .most_bytes = 256 * 8 * 9 * 2 * 3}), few);
  std::filesystem::remove(file);
}

/// A BTF of noise: no two texels alike, each view for itself.
std::shared_ptr<const Btf> noisy_btf(int side) {
  auto btf = std::make_shared<Btf>(*test::small_btf(side, 4));
  std::mt19937 random(7);
  std::uniform_real_distribution<float> tone(0.4f, 1.6f);
  for (BtfView& view : btf->views)
    for (std::uint16_t& value : view.factors) value = glm::packHalf1x16(tone(random) * glm::unpackHalf1x16(value));
  complete_btf(btf.get());
  return btf;
}

TEST(Interactions, ShareTheTableByTheErrorOfLightAndMaterial) {
  const std::string smooth = (std::filesystem::path(testing::TempDir()) / "interactions-smooth.exr").string(),
                    noisy = (std::filesystem::path(testing::TempDir()) / "interactions-noisy.exr").string();
  save_btf(smooth, *test::small_btf(3, 4));
  save_btf(noisy, *noisy_btf(24));
  Sheet calm = sheet_of(covered_with(noisy), 0.0f, 24), lively = sheet_of(covered_with(smooth), 0.0f, 24);
  const auto per_texel = static_cast<std::size_t>(3 * calm.incident.bins);
  for (std::size_t i = per_texel; i < calm.incident.radiance.size(); ++i)  // the light of the first texel everywhere
    calm.incident.radiance[i] = calm.incident.radiance[i % per_texel];
  std::mt19937 random(9);
  for (float& value : lively.incident.radiance) value *= 1e-9f * static_cast<float>(random() >> 2u);
  constexpr std::size_t kRoom = std::size_t{8} << 20;  // for 4,096 products of terms
  const auto error = [&](const Sheet& sheet, std::optional<InteractionCounts> counts) {
    return error_of(sheet, {.counts = counts, .most_bytes = kRoom});
  };
  const InteractionCounts for_light{64, 8, 4}, for_material{8, 4, 16};
  EXPECT_LT(error(calm, for_material), 0.7 * error(calm, for_light));
  EXPECT_LT(error(lively, for_light), 0.7 * error(lively, for_material));
  EXPECT_LE(error(calm, {}), 1.05 * error(calm, for_material));
  EXPECT_LE(error(lively, {}), 1.05 * error(lively, for_light));
  for (const std::string& file : {smooth, noisy}) std::filesystem::remove(file);
}

TEST(Interactions, RefuseWhatVariesInMoreThanItsColour) {
  Scene scene;
  Material worn = test::matte(glm::vec3(0.5f));
  worn.name = "Worn";
  worn.metallic_roughness_texture.image = 0;
  scene.materials.push_back(worn);
  scene.images.push_back(test::checkerboard());
  test::add(&scene, test::make_grid({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 1, 0), "sheet");
  const auto traced = build_path_scene({.scene = scene, .environment = test::constant_sky(0.0f)});
  const LightFieldAtlas atlas = make_atlas(traced->geometry, {{0, false}}, {.side = 4});
  IncidentField incident;
  incident.bins = Lumisphere().count();
  incident.masked.assign(atlas.texels.size(), false);
  incident.radiance.assign(atlas.texels.size() * static_cast<std::size_t>(3 * incident.bins), 1.0f);
  try {
    compress_interactions(*traced, atlas, incident, {}, kNever);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("Worn"), std::string::npos);
  }
}

TEST(Interactions, AreNotFinishedOnceCancelled) {
  const std::atomic<bool> cancelled{true};
  const Sheet sheet = sheet_of(test::matte(glm::vec3(0.5f)), 0.0f, 6);
  EXPECT_EQ(compress_interactions(*sheet.scene, sheet.atlas, sheet.incident, {}, cancelled), nullptr);
  const auto terms = compress_interactions(*sheet.scene, sheet.atlas, sheet.incident, {}, kNever);
  EXPECT_EQ(compute_interactions(*terms, cancelled), nullptr);
}

}  // namespace
}  // namespace maquette
