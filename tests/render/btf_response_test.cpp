// What BTFs make of light in bins, against direct sums over directions.
#include "render/slf/btf_response.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <random>

#include "render/reference/path_scene.h"
#include "render/reference/surface.h"
#include "render/slf/outgoing.h"
#include "scenes/btf/btf_file.h"
#include "scenes/btf/factorise.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

/// Of two by two texels: brighter where light comes from +x, by another share in each, and seen from +y.
Btf brushed() {
  Btf btf;
  btf.name = "brushed";
  btf.width = btf.height = 2;
  btf.components = 3;
  btf.texel_m = 0.5;
  const std::vector<glm::dvec3> directions = ubo_directions();
  const BtfLights lights = make_btf_lights(directions);
  for (const glm::dvec3& view : directions) {
    std::vector<float> images;
    for (const glm::dvec3& light : directions)
      for (int t = 0; t < 4; ++t)
        for (int c = 0; c < 3; ++c)
          images.push_back(static_cast<float>(0.2 + 0.15 * (0.3 + 0.2 * t) * light.x + 0.1 * view.y + 0.02 * c));
    btf.views.push_back(factorise_btf_view(view, lights, btf.components, &images));
  }
  complete_btf(&btf);
  return btf;
}

Eigen::VectorXf random_means(int bins, std::mt19937* random) {
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  Eigen::VectorXf means(bins);
  for (Eigen::Index k = 0; k < bins; ++k) means[k] = unit(*random) + (unit(*random) < 0.03f ? 20.0f : 0.0f);
  return means;
}

/// Integral of the BTF times light over the hemisphere. `to_btf`: from the texel's frame.
template <typename ToBtf>
glm::dvec3 direct_sum(const Btf& btf, const BtfLookup& at, const DirectionSpline& spline,
                      const Eigen::VectorXf& coefficients, const glm::vec3& wo, ToBtf to_btf) {
  glm::dvec3 sum(0.0);
  for (int k = 0; k < spline.lumisphere().count(); ++k)
    for (const DirectionSpline::BinSample& s : spline.bin_samples(k, 4))
      sum += glm::dvec3(evaluate_btf(btf, at, to_btf(s.direction), to_btf(wo))) *
             (static_cast<double>(spline.value(coefficients, s.direction)) * static_cast<double>(s.weight) *
              spline.lumisphere().projected(k));
  return sum;
}

TEST(BtfResponse, EqualsTheDirectSum) {
  const Btf btf = brushed();
  const DirectionSpline spline{Lumisphere()};
  std::mt19937 random(11);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (const BtfTurn& turn : {BtfTurn{0, false}, BtfTurn{13, false}, BtfTurn{70, true}}) {
    const BtfResponse response(btf, spline, turn);
    const std::vector<BtfLookup> at{{{0.25f, 0.25f}, 0.0f}, {{0.6f, 0.9f}, 0.2f}, {{0.5f, 0.5f}, 1.0f}};
    const Eigen::VectorXf means = random_means(spline.lumisphere().count(), &random),
                          light = spline.from_means(4) * means;
    std::array<Eigen::MatrixXf, 3> in, out;
    for (auto& channel : in) channel = means.replicate(1, static_cast<Eigen::Index>(at.size()));
    response.apply(at, in, &out);
    for (std::size_t i = 0; i < at.size(); ++i)
      for (int k = 0; k < 6; ++k) {
        const float z = 0.3f + 0.7f * unit(random), phi = 6.2831853f * unit(random), r = std::sqrt(1.0f - z * z);
        const glm::vec3 wo(r * std::cos(phi), r * std::sin(phi), z);
        const glm::dvec3 exact =
            direct_sum(btf, at[i], spline, light, wo, [&](const glm::vec3& d) { return turn.to_btf(d); });
        for (std::size_t c = 0; c < 3; ++c)
          EXPECT_NEAR(spline.value(out[c].col(static_cast<Eigen::Index>(i)), wo), exact[static_cast<int>(c)],
                      0.02 * exact[static_cast<int>(c)])
              << turn.step << " " << i;
      }
  }
}

/// Texels' frames and the surface's tangents differ by any angle, and the back is mirrored.
TEST(BtfResponse, FollowsTheTangentsOfTheSurface) {
  const std::string file = (std::filesystem::path(testing::TempDir()) / "brushed-btf.exr").string();
  save_btf(file, brushed());
  Scene scene;
  Material material;
  material.measured = file;
  material.double_sided = true;
  scene.materials.push_back(material);
  const float angle = 0.7f;
  const glm::vec3 x(std::cos(angle), std::sin(angle), 0.0f), y(-x.y, x.x, 0.0f);
  test::add(&scene, test::make_grid(-x - y, 2.0f * x, 2.0f * y, 1, 0), "sheet");
  const auto traced = build_path_scene({.scene = scene, .environment = test::constant_sky(0.0f)});
  const LightFieldAtlas atlas = make_atlas(traced->geometry, {{0, true}}, {.side = 8});
  const DirectionSpline spline{Lumisphere()};
  std::mt19937 random(23);
  IncidentField incident;
  incident.bins = spline.lumisphere().count();
  incident.masked.assign(atlas.texels.size(), false);
  std::vector<Eigen::VectorXf> means;
  for (std::size_t t = 0; t < atlas.texels.size(); ++t) {
    means.push_back(random_means(incident.bins, &random));
    for (Eigen::Index b = 0; b < incident.bins; ++b)
      incident.radiance.insert(incident.radiance.end(), 3, means.back()[b]);
  }
  const std::atomic<bool> never{false};
  const auto out = compute_outgoing(*traced, atlas, incident, {}, never);
  const Btf& btf = *traced->materials.front().btf;
  int backs = 0;
  for (std::size_t t = 0; t < atlas.texels.size(); t += 5) {
    const TexelFrame frame = frame_of_texel(traced->geometry, atlas, t);
    backs += atlas.sides[atlas.texels[t].side].back;
    RayHit hit;
    const Ray ray{frame.position + frame.geometric, -frame.geometric};
    ASSERT_TRUE(intersect(*traced, ray, RayKind::camera, 0, &hit));
    const SurfacePoint p = resolve_surface(*traced, ray, hit, {});
    const glm::vec3 wo = glm::normalize(glm::vec3(0.3f, 0.5f, 0.8f));
    const glm::dvec3 exact = direct_sum(btf, p.btf, spline, spline.from_means(4) * means[t], wo,
                                        [&](const glm::vec3& d) { return p.to_local(frame.to_world(d)); });
    Eigen::VectorXf red(incident.bins);
    for (Eigen::Index b = 0; b < incident.bins; ++b) red[b] = out->radiance(3 * b, static_cast<Eigen::Index>(t));
    EXPECT_NEAR(spline.value(red, wo), exact.x, 0.03 * exact.x) << t;
  }
  EXPECT_GT(backs, 0);
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace maquette
