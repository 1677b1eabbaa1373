#include "render/environment/environment_tables.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <numbers>
#include <random>
#include <set>

#include "render/math/low_discrepancy.h"
#include "scenes/angles.h"
#include "scenes/luminance.h"

namespace maquette {
namespace {

Environment make_environment(int width, int height, const std::function<double(const glm::dvec3&, int, int)>& value) {
  Environment e;
  e.width = width;
  e.height = height;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      e.rgb.emplace_back(static_cast<float>(value(direction_from_latlong(x + 0.5, y + 0.5, width, height), x, y)));
  return e;
}

Environment hot_texel(int width, int height, int hot_x, int hot_y, double background = 0.0) {
  return make_environment(width, height,
                          [&](const glm::dvec3&, int x, int y) { return x == hot_x && y == hot_y ? 1e6 : background; });
}

/// Integral of the bilinear luminance over the sphere by brute force: 16 x 16 midpoints a texel.
double integrate_luminance(const Environment& e) {
  constexpr int kSide = 16;
  double sum = 0.0;
  for (int y = 0; y < kSide * e.height; ++y) {
    const double v = (y + 0.5) / kSide;
    const double solid_angle = std::sin(std::numbers::pi * v / e.height) * std::numbers::pi / (kSide * e.height) * 2.0 *
                               std::numbers::pi / (kSide * e.width);
    for (int x = 0; x < kSide * e.width; ++x)
      sum += solid_angle *
             luminance(evaluate_environment(e, direction_from_latlong((x + 0.5) / kSide, v, e.width, e.height)));
  }
  return sum;
}

/// nu_L of the cell that contains a direction.
double bandwidth_at(const EnvironmentTables& t, const glm::dvec3& d) {
  const glm::dvec2 p = latlong_from_direction(d, t.bandwidth_width, t.bandwidth_height);
  const int x = std::min(static_cast<int>(p.x), t.bandwidth_width - 1);
  const int y = std::min(static_cast<int>(p.y), t.bandwidth_height - 1);
  return static_cast<double>(t.bandwidth[static_cast<std::size_t>(y * t.bandwidth_width + x)]);
}

std::vector<double> row_of(const EnvironmentTables& t, double latitude_deg) {
  const int y = static_cast<int>((90.0 - latitude_deg) / 180.0 * t.bandwidth_height);
  const auto begin = t.bandwidth.begin() + y * t.bandwidth_width;
  return {begin, begin + t.bandwidth_width};
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// Samples as mode `uniform` does, with a node at every `1 / refinement` of a texel.
std::vector<EnvironmentSample> sample(const Environment& e, const EnvironmentTables& t, std::uint32_t seed,
                                      std::size_t count, int refinement = 1) {
  return sample_environment(e, t, pack_sky(e, packing_bias(e), refinement), seed, count);
}

TEST(EnvironmentImportance, OneHotTexelIntegratesRight) {
  // In the middle, on the seam, at both poles: bilinear interpolation spreads the light by half a texel in every
  // direction.
  for (const auto& [x, y] : {std::pair{13, 7}, {0, 8}, {31, 9}, {5, 0}, {17, 15}}) {
    const Environment e = hot_texel(32, 16, x, y);
    const EnvironmentTables t = compute_environment_tables(e);
    const double expected = integrate_luminance(e);
    EXPECT_NEAR(t.luminance_integral / expected, 1.0, 2e-3);
    const auto samples = sample(e, t, 3, 16384);
    ASSERT_EQ(samples.size(), 16384u);
    double sum = 0.0;
    for (const EnvironmentSample& s : samples) {
      ASSERT_GT(s.pdf, 0.0f);
      sum += luminance(glm::dvec3(s.radiance)) / static_cast<double>(s.pdf);
    }
    EXPECT_NEAR(sum / 16384.0 / expected, 1.0, 5e-3) << x << ' ' << y;
  }
}

TEST(EnvironmentImportance, EveryDirectionWithLightCanBeSampled) {
  const Environment e = hot_texel(32, 16, 31, 4);
  const EnvironmentTables t = compute_environment_tables(e);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform;
  int lit = 0;
  for (int i = 0; i < 100000; ++i) {
    const double x = 32 * uniform(random), y = 16 * uniform(random);
    if (evaluate_environment(e, direction_from_latlong(x, y, 32, 16)).x <= 0.0) continue;
    ++lit;
    ASSERT_GT(t.density[static_cast<std::size_t>(static_cast<int>(y) * 32 + static_cast<int>(x))], 0.0f);
  }
  EXPECT_GT(lit, 100);
}

TEST(EnvironmentImportance, DensityIsOneOverTheSphereAndMatchesTheCdfs) {
  std::mt19937 random(2);
  std::lognormal_distribution<double> value(0.0, 2.0);
  const Environment e = make_environment(64, 32, [&](const glm::dvec3&, int, int) { return value(random); });
  const EnvironmentTables t = compute_environment_tables(e);
  double total = 0.0;
  for (int y = 0; y < 32; ++y) {
    const double solid_angle =
        2.0 * std::numbers::pi / 64 * (std::cos(std::numbers::pi * y / 32) - std::cos(std::numbers::pi * (y + 1) / 32));
    const auto row = static_cast<std::size_t>(y);
    for (std::size_t x = 0; x < 64; ++x) {
      const double cell = static_cast<double>(t.density[row * 64 + x]) * solid_angle;
      total += cell;
      const double marginal = static_cast<double>(t.marginal_cdf[row + 1]) - static_cast<double>(t.marginal_cdf[row]);
      const double conditional = static_cast<double>(t.conditional_cdf[row * 65 + x + 1]) -
                                 static_cast<double>(t.conditional_cdf[row * 65 + x]);
      EXPECT_NEAR(marginal * conditional, cell, 1e-6);
    }
  }
  EXPECT_NEAR(total, 1.0, 1e-5);
  EXPECT_NEAR(t.luminance_integral / integrate_luminance(e), 1.0, 1e-3);
}

TEST(EnvironmentImportance, SamplesFollowTheDensity) {
  const Environment e = make_environment(
      64, 32, [](const glm::dvec3& d, int, int) { return 1.0 + 3.0 * std::max(0.0, d.y) + (d.x > 0.9 ? 40.0 : 0.0); });
  const EnvironmentTables t = compute_environment_tables(e);
  constexpr std::size_t kCount = 65536;
  std::vector<double> counts(8 * 4), expected(8 * 4);
  double spread = 0.0;
  for (const EnvironmentSample& s : sample(e, t, 9, kCount)) {
    EXPECT_NEAR(glm::length(s.direction), 1.0f, 1e-5f);
    const glm::dvec2 p = latlong_from_direction(s.direction, 8, 4);
    counts[static_cast<std::size_t>(std::min(static_cast<int>(p.y), 3) * 8 + std::min(static_cast<int>(p.x), 7))] +=
        1.0;
    // A grey texel over its pdf is the light of the whole sphere, whichever texel was sampled, except for the variation
    // of sin(latitude) within a cell.
    if (p.y > 0.25 && p.y < 3.75) {
      const double ratio = luminance(glm::dvec3(s.radiance)) / static_cast<double>(s.pdf);
      ASSERT_NEAR(ratio / t.luminance_integral, 1.0, 0.2) << p.y;
      spread += (ratio / t.luminance_integral - 1.0) * (ratio / t.luminance_integral - 1.0) / kCount;
    }
  }
  EXPECT_LT(spread, 1e-4);
  for (std::size_t y = 0; y < 32; ++y)
    for (std::size_t x = 0; x < 64; ++x)
      expected[y / 8 * 8 + x / 8] += kCount * static_cast<double>(t.density[y * 64 + x]) * 2.0 * std::numbers::pi / 64 *
                                     (std::cos(std::numbers::pi * static_cast<double>(y) / 32) -
                                      std::cos(std::numbers::pi * static_cast<double>(y + 1) / 32));
  double chi_square = 0.0;
  for (std::size_t i = 0; i < counts.size(); ++i)
    chi_square += (counts[i] - expected[i]) * (counts[i] - expected[i]) / expected[i];
  // 31 degrees of freedom: 61 has a probability of one in a thousand for random samples; these are more uniform than
  // random ones.
  EXPECT_LT(chi_square, 31.0);
}

TEST(EnvironmentImportance, TexelsAreSampledByTheirShareOfTheLight) {
  // Two texels of 1 and 3 side by side: on the edge between them the brighter one is sampled three times as often.
  const Environment e = make_environment(2, 1, [](const glm::dvec3&, int x, int) { return x == 0 ? 1.0 : 3.0; });
  const EnvironmentTables t = compute_environment_tables(e);
  double bright = 0.0, expected = 0.0;
  for (const EnvironmentSample& s : sample(e, t, 2, 16384)) {
    const double x = latlong_from_direction(s.direction, 2, 1).x - 0.5;
    const double share = x < 1.0 ? std::abs(x) : 2.0 - x;  // bilinear weight of the second
    expected += 3.0 * share / (3.0 * share + 1.0 - share);
    bright += luminance(glm::dvec3(s.radiance)) > 2.0 ? 1.0 : 0.0;
  }
  EXPECT_NEAR(bright / expected, 1.0, 0.01);
}

TEST(EnvironmentImportance, RunsOfConsecutiveSamplesAreWellSpread) {
  const Environment e = make_environment(64, 32, [](const glm::dvec3&, int, int) { return 1.0; });
  const auto samples = sample(e, compute_environment_tables(e), 4, 65536);
  // On a constant sky each aligned run of 256 has one sample in each of 16 x 16 equal-area boxes.
  for (const std::size_t begin : {0u, 256u, 5120u, 65280u}) {
    std::set<int> boxes;
    for (std::size_t i = begin; i < begin + 256; ++i) {
      const glm::vec3& d = samples[i].direction;
      const double u = 0.5 - std::atan2(static_cast<double>(d.x), static_cast<double>(d.z)) / (2.0 * std::numbers::pi);
      const double v = 0.5 - 0.5 * static_cast<double>(d.y);
      boxes.insert(std::min(static_cast<int>(v * 16), 15) * 16 + std::min(static_cast<int>(u * 16), 15));
    }
    EXPECT_GE(boxes.size(), 254u);  // directions are rounded to float: a sample on a border may move across it
  }
}

TEST(EnvironmentImportance, DependsOnTheSeedAlone) {
  const Environment e = hot_texel(32, 16, 4, 4, 1.0);
  const EnvironmentTables t = compute_environment_tables(e);
  const auto a = sample(e, t, 1, 64), b = sample(e, t, 1, 128), c = sample(e, t, 2, 64);
  EXPECT_EQ(a[63].direction, b[63].direction);
  EXPECT_NE(a[63].direction, c[63].direction);
}

// Samples are computed cell by cell, in a different order.
TEST(EnvironmentImportance, ListHoldsTheSequenceInItsOrder) {
  const Environment e = make_environment(
      64, 32, [](const glm::dvec3& d, int x, int y) { return 1.0 + d.y + (x == 0 && y == 9 ? 1e5 : 0.0); });
  const EnvironmentTables t = compute_environment_tables(e);
  const std::uint32_t seed = 5, seeds[2] = {mix_seed(seed, 0), mix_seed(seed, 1)};
  const auto list = sample(e, t, seed, 5000);
  ASSERT_EQ(list.size(), 5000u);
  for (std::uint32_t i = 0; i < 5000; ++i) {
    const double u = owen_scramble(reverse_bits(i), seeds[0]) * 0x1p-32;
    const double v = owen_scramble(reverse_bits(sobol_second_reversed(i)), seeds[1]) * 0x1p-32;
    ASSERT_EQ(list[i].direction, sample_environment_direction(e, t, u, v).direction) << i;
  }
}

TEST(EnvironmentImportance, ExtremesAreFinite) {
  const Environment black = make_environment(32, 16, [](const glm::dvec3&, int, int) { return 0.0; });
  const EnvironmentTables dark = compute_environment_tables(black);
  EXPECT_EQ(dark.luminance_integral, 0.0);
  EXPECT_TRUE(sample(black, dark, 0, 100).empty());
  EXPECT_EQ(dark.marginal_cdf.back(), 1.0f);
  EXPECT_EQ(*std::max_element(dark.bandwidth.begin(), dark.bandwidth.end()), 0.0f);

  const Environment one = make_environment(1, 1, [](const glm::dvec3&, int, int) { return 2.0; });
  const EnvironmentTables t = compute_environment_tables(one);
  EXPECT_NEAR(t.luminance_integral, 8.0 * std::numbers::pi, 1e-5);
  for (const EnvironmentSample& s : sample(one, t, 0, 100)) EXPECT_NEAR(s.pdf, 1.0 / (4.0 * std::numbers::pi), 1e-6);
  EXPECT_EQ(*std::max_element(t.bandwidth.begin(), t.bandwidth.end()), 0.0f);

  // Far outside the usual range of float. Packed values end at 1e-33 (a step of 2^-110), tables do not.
  for (const double scale : {1e-38, 1e-29, 1e15}) {
    const Environment e = make_environment(
        32, 16, [&](const glm::dvec3&, int x, int y) { return x == 3 && y == 3 ? scale : scale * 1e-3; });
    const EnvironmentTables extreme = compute_environment_tables(e);
    double sum = 0.0, drawn = 0.0;
    for (const EnvironmentSample& s : sample(e, extreme, 0, 4096)) {
      ASSERT_TRUE(std::isfinite(s.pdf) && s.pdf > 0.0f);
      sum += luminance(glm::dvec3(s.radiance)) / static_cast<double>(s.pdf) / 4096.0;
    }
    for (std::uint32_t i = 0; i < 4096; ++i) {
      const EnvironmentDirection d = sample_environment_direction(e, extreme, reverse_bits(i) * 0x1p-32,
                                                                  reverse_bits(sobol_second_reversed(i)) * 0x1p-32);
      ASSERT_TRUE(std::isfinite(d.pdf) && d.pdf > 0.0f);
      drawn += luminance(glm::vec3(1e-3 / scale * evaluate_environment(e, d.direction))) / static_cast<double>(d.pdf) /
               4096.0;
    }
    EXPECT_NEAR(drawn / (1e-3 / scale * extreme.luminance_integral), 1.0, 0.01);
    if (scale > 1e-33) {
      EXPECT_NEAR(sum / extreme.luminance_integral, 1.0, 0.01);
    }
    for (const float nu : extreme.bandwidth) ASSERT_TRUE(std::isfinite(nu) && nu >= 0.0f);
  }
}

TEST(EnvironmentBandwidth, CosineSkyHasItsClosedForm) {
  for (const int m : {4, 6, 8, 9, 14, 21, 34, 55}) {
    const Environment e = make_environment(
        256, 128, [&](const glm::dvec3& d, int, int) { return 1.0 + std::cos(m * std::atan2(d.x, d.z)); });
    const EnvironmentTables t = compute_environment_tables(e);
    const double expected = m / (2.0 * std::numbers::pi);
    const std::vector<double> equator = row_of(t, 0.3);
    EXPECT_NEAR(median(equator) / expected, 1.0, 0.2) << m;
    // In the dark troughs of a slow cosine the far brighter light is clipped.
    EXPECT_LT(*std::max_element(equator.begin(), equator.end()) / expected, m < 14 ? 3.0 : 1.4) << m;
    EXPECT_GT(*std::min_element(equator.begin(), equator.end()) / expected, 0.75) << m;
    // On smaller circles of latitude the same period covers a smaller angle.
    EXPECT_NEAR(median(row_of(t, 60.0)) * std::cos(radians(60.0)) / expected, 1.0, 0.25) << m;
  }
}

TEST(EnvironmentBandwidth, CosineOfTheLatitudeHasItsClosedForm) {
  for (const int m : {8, 12, 28, 52}) {
    const Environment e =
        make_environment(256, 128, [&](const glm::dvec3& d, int, int) { return 1.0 + std::cos(m * std::acos(d.y)); });
    const EnvironmentTables t = compute_environment_tables(e);
    for (const double latitude : {-50.0, 0.3, 40.0})
      EXPECT_NEAR(median(row_of(t, latitude)) * 2.0 * std::numbers::pi / m, 1.0, 0.2) << m << ' ' << latitude;
  }
}

TEST(EnvironmentBandwidth, ContrastAndScaleDoNotMatter) {
  const auto nu = [](double scale, double contrast) {
    const Environment e = make_environment(256, 128, [&](const glm::dvec3& d, int, int) {
      return scale * (1.0 + contrast * std::cos(20 * std::atan2(d.x, d.z)));
    });
    return median(row_of(compute_environment_tables(e), 0.3));
  };
  EXPECT_NEAR(nu(1.0, 1.0) / nu(1e5, 1.0), 1.0, 1e-3);
  EXPECT_NEAR(nu(1.0, 1.0) / nu(1.0, 0.2), 1.0, 0.05);
  EXPECT_EQ(nu(1.0, 0.005), 0.0);  // below the threshold of a change
}

TEST(EnvironmentBandwidth, AConstantSkyHasNone) {
  const EnvironmentTables t =
      compute_environment_tables(make_environment(256, 128, [](const glm::dvec3&, int, int) { return 7.0; }));
  EXPECT_EQ(*std::max_element(t.bandwidth.begin(), t.bandwidth.end()), 0.0f);
}

/// nu_L through lobe k, in the middle column.
double seen_at(const EnvironmentTables& t, int row, std::size_t k) {
  const int cell = row * t.bandwidth_width + t.bandwidth_width / 2;
  return static_cast<double>(t.seen_bandwidth[static_cast<std::size_t>(cell) * kSeenBandwidthCount + k]);
}

/// A sky that depends on the elevation alone, filtered by Gaussian lobes: the result is known in closed form (erf). The
/// tables of the sharp sky must give the filtered sky's local bandwidth, averaged over the lobe by energy as shading
/// does. min(nu_L, nu_rho) would be wrong.
TEST(EnvironmentBandwidth, AnEdgeSeenThroughALobeHasTheBandwidthOfItsBlur) {
  constexpr int kWidth = 512, kHeight = 256;
  const auto elevation_of = [](double row, int height) { return std::numbers::pi * (0.5 - row / height); };
  const auto sky = [&](double sigma) {
    return make_environment(kWidth, kHeight, [&](const glm::dvec3&, int, int y) {
      const double e = elevation_of(y + 0.5, kHeight) - 0.013;
      return sigma > 0.0 ? 1.5 + 0.5 * std::erf(e / (std::numbers::sqrt2 * sigma)) : (e > 0.0 ? 2.0 : 1.0);
    });
  };
  const EnvironmentTables sharp = compute_environment_tables(sky(0.0));
  for (std::size_t k = 2; k < 6; ++k) {
    const double nu_rho = seen_through(k),
                 sigma = 1.386 / (2.0 * std::numbers::pi * nu_rho);  // 95 % of the lobe's energy below nu_rho
    const EnvironmentTables blurred = compute_environment_tables(sky(sigma));
    std::vector<double> ratios, of_least;
    for (int y = 0; y < sharp.bandwidth_height; ++y) {
      const double e = elevation_of(y + 0.5, sharp.bandwidth_height);
      if (std::abs(e) > std::max(3.0 * sigma, 0.1)) continue;
      double seen = 0.0, least = 0.0, energy = 0.0;
      for (int j = 0; j < sharp.bandwidth_height; ++j) {
        const double to = elevation_of(j + 0.5, sharp.bandwidth_height), x = (to - e) / sigma;
        const double w = std::exp(-0.5 * x * x) * (to > 0.013 ? 2.0 : 1.0);
        const auto own = static_cast<double>(sharp.bandwidth[static_cast<std::size_t>(j * sharp.bandwidth_width)]);
        seen += w * seen_at(sharp, j, k);
        least += w * std::min(own, nu_rho);
        energy += w;
      }
      const auto truth = static_cast<double>(blurred.bandwidth[static_cast<std::size_t>(y * blurred.bandwidth_width)]);
      ratios.push_back(seen / energy / truth);
      of_least.push_back(least / energy / truth);
    }
    std::sort(ratios.begin(), ratios.end());
    std::sort(of_least.begin(), of_least.end());
    EXPECT_NEAR(median(ratios), 0.95, 0.15) << nu_rho;
    EXPECT_GT(ratios.front(), 0.55) << nu_rho;  // cells of 1.4 degrees are coarse beside the narrowest lobe
    EXPECT_LT(ratios.back(), 1.5) << nu_rho;
    EXPECT_GT(median(of_least), 1.4) << nu_rho;
  }
}

TEST(EnvironmentBandwidth, ALobeKeepsWavesWithinItsBandwidth) {
  for (const int m : {9, 21, 55}) {
    const EnvironmentTables t = compute_environment_tables(make_environment(
        256, 128, [&](const glm::dvec3& d, int, int) { return 1.0 + 0.5 * std::cos(m * std::acos(d.y)); }));
    const int row = t.bandwidth_height / 2;
    const auto own = static_cast<double>(t.bandwidth[static_cast<std::size_t>(row * t.bandwidth_width)]);
    for (std::size_t k = 0; k < kSeenBandwidthCount; ++k) {
      if (seen_through(k) < 2.0 * own) continue;
      EXPECT_NEAR(seen_at(t, row, k) / own, 1.0, 0.1) << m << ' ' << k;
    }
  }
}

/// Narrower lobes have no lower bandwidth, none exceeds that of the light, and a constant has none.
TEST(EnvironmentBandwidth, NarrowerLobesKeepMoreBandwidth) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  const EnvironmentTables noise = compute_environment_tables(make_environment(
      128, 64, [&](const glm::dvec3&, int x, int) { return std::pow(u(random), x < 64 ? 8.0 : 1.0); }));
  int told = 0;
  for (std::size_t cell = 0; cell < noise.bandwidth.size(); ++cell) {
    const float* seen = &noise.seen_bandwidth[cell * kSeenBandwidthCount];
    for (std::size_t k = 0; k + 1 < kSeenBandwidthCount; ++k) ASSERT_LE(seen[k], seen[k + 1]) << cell << ' ' << k;
    ASSERT_LE(seen[kSeenBandwidthCount - 1], noise.bandwidth[cell]);
    told += seen[2] < 0.5f * noise.bandwidth[cell];
  }
  EXPECT_GT(told, static_cast<int>(noise.bandwidth.size() / 2));
  const EnvironmentTables even =
      compute_environment_tables(make_environment(128, 64, [](const glm::dvec3&, int, int) { return 7.0; }));
  EXPECT_EQ(*std::max_element(even.seen_bandwidth.begin(), even.seen_bandwidth.end()), 0.0f);
}

TEST(EnvironmentBandwidth, ASunRaisesOnlyItsNeighbourhood) {
  const glm::dvec3 sun = direction_from_latlong(300.0, 90.0, 1024, 512);
  const auto sky = [](const glm::dvec3& d) { return 2.0 + d.y + 0.3 * d.x; };
  const auto with_sun = [&](const glm::dvec3& d, int, int) {
    return sky(d) + (glm::dot(d, sun) > std::cos(0.006) ? 1e6 : 0.0);
  };
  const EnvironmentTables plain =
      compute_environment_tables(make_environment(1024, 512, [&](const glm::dvec3& d, int, int) { return sky(d); }));
  const EnvironmentTables sunny = compute_environment_tables(make_environment(1024, 512, with_sun));
  // The disc is 0.012 rad wide: its bandwidth is about 1 / 0.024 cycles per radian.
  EXPECT_GT(bandwidth_at(sunny, sun), 20.0);
  EXPECT_LT(bandwidth_at(plain, sun), 2.0);
  double farthest_raised = 0.0;
  int raised = 0;
  for (std::size_t i = 0; i < sunny.bandwidth.size(); ++i) {
    const auto w = static_cast<std::size_t>(sunny.bandwidth_width);
    const glm::dvec3 d = direction_from_latlong(static_cast<double>(i % w) + 0.5, static_cast<double>(i / w) + 0.5,
                                                sunny.bandwidth_width, sunny.bandwidth_height);
    if (sunny.bandwidth[i] < plain.bandwidth[i] + 4.0f) continue;
    ++raised;
    farthest_raised = std::max(farthest_raised, std::acos(std::clamp(glm::dot(d, sun), -1.0, 1.0)));
  }
  EXPECT_LT(farthest_raised, radians(25.0));
  EXPECT_LT(raised, static_cast<int>(sunny.bandwidth.size() / 200));
}

TEST(EnvironmentBandwidth, DetailBesideASunIsNotBuried) {
  const glm::dvec3 sun = direction_from_latlong(256.0, 90.0, 512, 256);
  const Environment e = make_environment(256, 128, [&](const glm::dvec3& d, int, int) {
    return 1.0 + 0.5 * std::cos(40 * std::atan2(d.x, d.z)) + (glm::dot(d, sun) > std::cos(0.02) ? 1e6 : 0.0);
  });
  EXPECT_NEAR(
      median(row_of(compute_environment_tables(e), -20.0)) * std::cos(radians(20.0)) * 2.0 * std::numbers::pi / 40, 1.0,
      0.25);
}

TEST(EnvironmentBandwidth, ALargeMapKeepsItsFinestDetail) {
  const Environment e = make_environment(4096, 2048, [&](const glm::dvec3&, int x, int) { return 1.0 + (x / 2) % 2; });
  const double nu = median(row_of(compute_environment_tables(e), 0.3));
  EXPECT_NEAR(nu / (1024 / (2.0 * std::numbers::pi)), 1.0,
              0.7);  // period of 4 texels, a square wave next to the Nyquist limit
}

TEST(EnvironmentTablesCache, GivesTheSameTables) {
  const auto folder = std::filesystem::temp_directory_path() / ("maquette_tables_" + std::to_string(::getpid()));
  const char* before = std::getenv("MAQUETTE_CACHE");
  const std::string saved = before ? before : "";
  ::setenv("MAQUETTE_CACHE", folder.c_str(), 1);
  Environment e = hot_texel(64, 32, 7, 9, 1.0);
  const EnvironmentTables computed = compute_environment_tables(e);
  const EnvironmentTables first = load_environment_tables(e);
  EXPECT_FALSE(std::filesystem::is_empty(folder));
  const EnvironmentTables second = load_environment_tables(e);
  for (const EnvironmentTables* t : {&first, &second}) {
    EXPECT_EQ(t->bandwidth, computed.bandwidth);
    EXPECT_EQ(t->seen_bandwidth, computed.seen_bandwidth);
    EXPECT_EQ(t->bandwidth_width, computed.bandwidth_width);
    EXPECT_EQ(t->density, computed.density);
  }
  before ? ::setenv("MAQUETTE_CACHE", saved.c_str(), 1) : ::unsetenv("MAQUETTE_CACHE");
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace maquette
