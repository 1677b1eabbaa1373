// The reference path tracer against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>

#include "render/materials/brdf_tables.h"
#include "render/materials/symmetric_brdf.h"
#include "scenes/angles.h"
#include "scenes/luminance.h"
#include "tests/support/chi_square.h"
#include "tests/support/cornell.h"
#include "tests/support/path_scenes.h"
#include "tests/support/quadrature.h"

namespace maquette::test {

MeanRadiance mean_radiance(const PathScene& scene, const PathOptions& options, const glm::vec3& origin,
                           const glm::vec3& direction, std::uint32_t count, std::uint32_t seed) {
  constexpr std::uint32_t kRuns = 16;
  MeanRadiance result;
  std::vector<double> runs;
  for (std::uint32_t run = 0; run < kRuns; ++run) {
    glm::dvec3 sum(0.0);
    for (std::uint32_t i = 0; i < count / kRuns; ++i)
      sum += glm::dvec3(estimate_radiance(scene, options, origin, direction, seed * 7919u + run, i));
    sum /= static_cast<double>(count / kRuns);
    result.mean += sum / static_cast<double>(kRuns);
    runs.push_back(luminance(sum));
  }
  const double mean = luminance(result.mean);
  double square = 0.0;
  for (const double r : runs) square += (r - mean) * (r - mean);
  result.deviation = std::sqrt(square / (kRuns * (kRuns - 1.0)));
  return result;
}

namespace {

/// The floor y = 0, seen from `degrees` off its normal at the origin.
struct FloorView {
  glm::vec3 origin{}, direction{};
  explicit FloorView(double degrees) {
    const double t = degrees * kDegree;
    const glm::dvec3 wo(std::sin(t), std::cos(t), 0.0);
    origin = glm::vec3(2.0 * wo);
    direction = glm::vec3(-wo);
  }
};
Primitive floor_quad(float half = 50.0f) { return quad({-half, 0, half}, {2 * half, 0, 0}, {0, 0, -2 * half}); }

/// Every material of the library shows its albedo in a furnace, which is computed by quadrature of the table; 1 for a
/// lossless material.
TEST(PathTracer, EveryBuiltInMaterialShowsItsAlbedoInAFurnace) {
  double worst = 0.0;
  for (const BuiltinBrdf& entry : builtin_brdfs()) {
    Material material;
    material.measured = "builtin:" + entry.name;
    const auto scene = trace(scene_of(floor_quad(), material), constant_sky(1.0f));
    BrdfTables tables;
    compute_albedo(SymmetricBrdf(make_builtin_brdf(entry.name)), tables);
    for (const std::size_t i : {4u, 28u, 52u}) {
      const FloorView view(90.0 * static_cast<double>(i) / (kAlbedoCount - 1));
      const MeanRadiance seen =
          mean_radiance(*scene, {}, view.origin, view.direction, static_cast<std::uint32_t>(test_samples(8192)));
      const glm::dvec3 albedo(tables.albedo[i]);
      const double expected = luminance(albedo);
      const double mean = luminance(seen.mean);
      EXPECT_NEAR(mean, expected, 1e-3 * expected + 4.0 * seen.deviation) << entry.name << " row " << i;
      EXPECT_LT(seen.deviation, 3e-3 * expected) << entry.name << " row " << i;
      worst = std::max(worst, std::abs(mean / expected - 1.0));
    }
  }
  std::printf("furnace, library: worst %.5f\n", worst);
}

/// Lossless surfaces are invisible in a furnace: white Lambert, perfect mirror, clear pane.
TEST(PathTracer, LosslessSurfacesVanishInAFurnace) {
  Material mirror;
  mirror.metallic = 1.0f;
  mirror.roughness = 0.0f;
  Material pane = matte(glm::vec3(1.0f));
  pane.specular = 1.0f;
  pane.glass = true;
  pane.transmission = 1.0f;
  pane.roughness = 0.0f;
  pane.double_sided = true;
  for (const Material& material : {matte(glm::vec3(1.0f)), mirror, pane}) {
    const auto scene = trace(scene_of(fine_sphere(64), material), constant_sky(1.0f));
    PictureRequest request;
    request.camera.eye = {0, 0, 3};
    request.width = request.height = 24;
    ReferencePicture picture(scene, request);
    ASSERT_TRUE(picture.add(256));
    const Image mean = picture.mean();
    double sum = 0.0, lowest = 1e9;
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 24; ++x) {
        sum += static_cast<double>(mean.at(x, y, 1)) / 576.0;
        lowest = std::min(lowest, static_cast<double>(mean.at(x, y, 1)));
      }
    EXPECT_NEAR(sum, 1.0, 1e-3) << "metallic " << material.metallic << ", glass " << material.glass;
    EXPECT_GT(lowest, 0.9);
  }
}

/// L(w) = 1 + w.y: irradiance is pi (1 + 2/3 n.y).
TEST(PathTracer, LambertSphereUnderACosineSky) {
  const auto sky = sky_of(256, 128, [](const glm::dvec3& d) { return glm::dvec3(1.0 + d.y); });
  const auto scene = trace(scene_of(fine_sphere(128), matte({0.6f, 0.6f, 0.6f})), sky);
  double square = 0.0, mean = 0.0;
  constexpr int kPoints = 48;
  for (int i = 0; i < kPoints; ++i) {
    const double y = 1.0 - 2.0 * (i + 0.5) / kPoints, phi = 2.39996 * i;
    const glm::dvec3 n(std::sqrt(1 - y * y) * std::cos(phi), y, std::sqrt(1 - y * y) * std::sin(phi));
    const double seen = mean_radiance(*scene, {}, glm::vec3(3.0 * n), glm::vec3(-n), 4096).mean.y;
    const double expected = 0.6 * (1.0 + 2.0 / 3.0 * y);
    square += (seen - expected) * (seen - expected) / kPoints;
    mean += expected / kPoints;
  }
  std::printf("Lambert sphere under a cosine sky: relative RMSE %.5f\n", std::sqrt(square) / mean);
  EXPECT_LT(std::sqrt(square) / mean, 2e-3);
}

/// A mirror shows the sky in the mirror direction; its lobe of 0.06 degrees does not blur a sky of four waves.
TEST(PathTracer, MirrorSphereShowsTheSky) {
  const auto radiance = [](const glm::dvec3& d) { return 1.0 + 0.8 * d.x * d.z + 0.5 * d.y; };
  const auto sky = sky_of(512, 256, [&](const glm::dvec3& d) { return glm::dvec3(radiance(d)); });
  Material mirror;
  mirror.metallic = 1.0f;
  mirror.roughness = 0.0f;
  const auto scene = trace(scene_of(fine_sphere(256), mirror), sky);
  double square = 0.0, mean = 0.0;
  constexpr int kSide = 20;
  int count = 0;
  for (int k = 0; k < kSide * kSide; ++k) {
    const double x = (k % kSide + 0.5) / kSide * 1.9 - 0.95, y = (k / kSide + 0.5) / kSide * 1.9 - 0.95;
    if (x * x + y * y > 0.9) continue;
    const glm::dvec3 n(x, y, std::sqrt(1.0 - x * x - y * y));
    const double expected = radiance(glm::dvec3(2.0 * n.z * n.x, 2.0 * n.z * n.y, 2.0 * n.z * n.z - 1.0));
    const double seen =
        mean_radiance(*scene, {}, glm::vec3(static_cast<float>(x), static_cast<float>(y), 4.0f), {0, 0, -1}, 1024)
            .mean.y;
    square += (seen - expected) * (seen - expected);
    mean += expected;
    ++count;
  }
  const double relative = std::sqrt(square / count) / (mean / count);
  std::printf("mirror sphere: relative RMSE %.5f\n", relative);
  EXPECT_LT(relative, 3e-3);
}

/// Known values of a clear pane, n = 1.52, both faces: reflection of the bright half, and transmission from it.
TEST(PathTracer, PaneFollowsFresnel) {
  Material pane = matte(glm::vec3(1.0f));
  pane.specular = 1.0f;
  pane.glass = true;
  pane.transmission = 1.0f;
  pane.roughness = 0.0f;
  pane.ior = 1.52f;
  pane.double_sided = true;
  const auto above = trace(scene_of(floor_quad(), pane),
                           sky_of(64, 32, [](const glm::dvec3& d) { return glm::dvec3(d.y > 0.0 ? 1.0 : 0.0); }));
  const auto below = trace(scene_of(floor_quad(), pane),
                           sky_of(64, 32, [](const glm::dvec3& d) { return glm::dvec3(d.y > 0.0 ? 0.0 : 1.0); }));
  const auto reflectance = [](double theta) {
    const double n = 1.52, c = std::cos(theta), t = std::sqrt(1.0 - std::sin(theta) * std::sin(theta) / (n * n));
    const double s = std::pow((c - n * t) / (c + n * t), 2), p = std::pow((t - n * c) / (t + n * c), 2);
    return 0.5 * (2.0 * s / (1.0 + s) + 2.0 * p / (1.0 + p));  // the sum over all bounces, t = 1
  };
  for (const auto& [degrees, known] :
       std::map<double, double>{{0, -1}, {45, 0.098}, {60, 0.157}, {65, 0.203}, {70, 0.275}, {80, -1}}) {
    const FloorView view(degrees);
    const double expected = reflectance(degrees * kDegree);
    if (known > 0.0) {
      EXPECT_NEAR(expected, known, 6e-4) << degrees;
    }
    EXPECT_NEAR(mean_radiance(*above, {}, view.origin, view.direction, 4096).mean.y, expected, 1e-3) << degrees;
    EXPECT_NEAR(mean_radiance(*below, {}, view.origin, view.direction, 4096).mean.y, 1.0 - expected, 1e-3) << degrees;
  }
}

/// The box against the linear system. The noise of the paths is measured and removed from the error.
TEST(PathTracer, CornellBoxMatchesTheLinearSystem) {
  const Radiosity radiosity(cornell_triangles(), {.largest_edge = 0.8, .rays = 1024, .light_cells = 16});
  const auto scene = trace(load_scene("builtin:cornell"), constant_sky(0.0f));
  const CornellView view(12);
  const auto paths = static_cast<std::uint32_t>(test_samples(4096));
  double square = 0.0, noise = 0.0, mean = 0.0, seen_mean = 0.0;
  int count = 0;
  for (const CornellPixel& pixel : view.pixels(radiosity)) {
    const glm::dvec3 expected =
        pixel.hit.albedo / std::numbers::pi * radiosity.irradiance(pixel.hit.position, pixel.hit.normal, 4096);
    // Starts at a hundredth of the way to the camera: nothing is in between.
    const glm::dvec3 eye = pixel.hit.position + 0.01 * (glm::dvec3(0.0, 2.73, 10.8) - pixel.hit.position);
    const MeanRadiance seen =
        mean_radiance(*scene, {}, glm::vec3(eye), glm::vec3(glm::normalize(pixel.hit.position - eye)), paths,
                      static_cast<std::uint32_t>(count + 1));
    square += std::pow(luminance(seen.mean) - luminance(expected), 2);
    noise += seen.deviation * seen.deviation;
    mean += luminance(expected);
    seen_mean += luminance(seen.mean);
    ++count;
  }
  ASSERT_GT(count, 70);
  const double relative = std::sqrt(square / count) / (mean / count), own = std::sqrt(noise / count) / (mean / count);
  const double left = std::sqrt(std::max(square - noise, 0.0) / count) / (mean / count);
  std::printf(
      "Cornell box, %d points, %u paths: relative RMSE %.5f, noise of the paths %.5f, without it %.5f; mean %.5f of "
      "the solver's\n",
      count, paths, relative, own, left, seen_mean / mean);
  EXPECT_NEAR(seen_mean / mean, 1.0, 5e-3);
  EXPECT_LT(left, 6e-3);
}

/// The restricted reference (direct light of the environment, no visibility) against quadrature of the same tables and
/// texels.
TEST(PathTracer, RestrictedReferenceMatchesQuadrature) {
  const auto sky = std::make_shared<const Environment>(load_environment("builtin:studio"));
  const EnvironmentMoments moments(*sky);
  for (const char* name : {"matte-white", "leather-tan", "paint-red-metallic"}) {
    Material material;
    material.measured = std::string("builtin:") + name;
    const auto scene = trace(scene_of(fine_sphere(256), material), sky);
    const BrdfTable brdf = make_builtin_brdf(name);
    PathOptions options;
    options.transport = Transport::direct;
    double square = 0.0, noise = 0.0, mean = 0.0;
    constexpr int kPoints = 12;
    for (int i = 0; i < kPoints; ++i) {
      const double r = 0.95 * std::sqrt((i + 0.5) / kPoints), phi = 2.39996 * i;
      const glm::dvec3 n(r * std::cos(phi), r * std::sin(phi), std::sqrt(1.0 - r * r));
      LitPoint point;
      point.normal = n;
      point.wo = {0.0, 0.0, 1.0};
      const double expected = evaluate_direct(moments, brdf, point, {}).radiance.y;
      const MeanRadiance seen =
          mean_radiance(*scene, options, glm::vec3(n.x, n.y, 4.0), {0, 0, -1},
                        static_cast<std::uint32_t>(test_samples(16384)), static_cast<std::uint32_t>(i));
      square += std::pow(seen.mean.y - expected, 2);
      noise += seen.deviation * seen.deviation;
      mean += expected;
    }
    const double relative = std::sqrt(square / kPoints) / (mean / kPoints);
    const double left = std::sqrt(std::max(square - noise, 0.0) / kPoints) / (mean / kPoints);
    std::printf("restricted reference, %s: relative RMSE %.5f, without the paths' noise %.5f\n", name, relative, left);
    EXPECT_LT(left, 2.5e-3) << name;
    EXPECT_LT(relative, 6e-3) << name;
  }
}

}  // namespace
}  // namespace maquette::test
