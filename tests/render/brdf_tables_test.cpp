#include "render/materials/brdf_tables.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <numbers>
#include <random>

#include "render/materials/bandwidth.h"
#include "render/materials/brdf_sampler.h"
#include "render/materials/symmetric_brdf.h"
#include "scenes/angles.h"
#include "scenes/files.h"

namespace {

using namespace maquette;
using shared::BrdfSampler;

/// f(theta_h, theta_d, phi_d in [0, pi]) at bin centres.
BrdfTable tabulate(const std::function<glm::vec3(double, double, double)>& f) {
  BrdfTable table;
  table.rgb.reserve(kBrdfEntryCount);
  for (int h = 0; h < kThetaHCount; ++h) {
    for (int d = 0; d < kThetaDCount; ++d) {
      for (int p = 0; p < kPhiDCount; ++p) {
        table.rgb.push_back(
            f(theta_h_of_bin_edge(h + 0.5), (d + 0.5) / 90.0 * kHalfPi, (p + 0.5) / 180.0 * std::numbers::pi));
      }
    }
  }
  table.hash = content_hash(std::as_bytes(std::span(table.rgb)));
  return table;
}

BrdfTable lambert() {
  return tabulate(
      [](double, double, double) { return glm::vec3(0.5f, 0.4f, 0.3f) / static_cast<float>(std::numbers::pi); });
}
/// Gaussian lobe in theta_h over a faint diffuse base, stronger at grazing angles.
BrdfTable lobe(double width_rad, float base) {
  return tabulate([=](double h, double d, double) {
    const double lobe_value =
        std::exp(-0.5 * h * h / (width_rad * width_rad)) / (8.0 * std::numbers::pi * width_rad * width_rad);
    return glm::vec3(static_cast<float>(lobe_value * (0.3 + 0.7 * std::pow(1.0 - std::cos(d), 5.0)))) + glm::vec3(base);
  });
}
/// Changes with phi_d, without mirror symmetry.
BrdfTable lopsided() {
  return tabulate([](double h, double d, double p) {
    return glm::vec3(static_cast<float>(0.1 + 0.08 * std::sin(2.0 * p) * std::sin(d) + 0.3 * std::exp(-20.0 * h * h)));
  });
}
BrdfTable black() {
  return tabulate([](double, double, double) { return glm::vec3(0.0f); });
}
/// All energy in the first bin of theta_h: the closest to a mirror that the format allows.
BrdfTable mirror() {
  return tabulate([](double h, double, double) { return glm::vec3(h < 3e-4 ? 1e6f : 0.0f); });
}

glm::dvec3 direction(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

TEST(ThetaCells, MassesSumToOneAndSamplingFollowsThem) {
  const BrdfTables none;
  BrdfSampler sampler(none);
  double sum = 0.0;
  for (int k = 0; k < kThetaCellCount; ++k) {
    const double mass = static_cast<double>(sampler.theta_cell_mass(k));
    for (double inside : {0.02, 0.5, 0.98}) {
      const auto choice = sampler.theta_cell_of(static_cast<float>(sum + inside * mass));
      ASSERT_EQ(choice.k, k);
      EXPECT_NEAR(choice.position, inside, 2e-3) << k;
    }
    sum += mass;
  }
  EXPECT_NEAR(sum, 1.0, 1e-6);
  for (float u : {0.0f, 0.5f, 0.99999994f, 1.0f}) {
    const auto choice = sampler.theta_cell_of(u);
    EXPECT_GE(choice.k, 0);
    EXPECT_LT(choice.k, kThetaCellCount);
    EXPECT_GE(choice.position, 0.0f);
    EXPECT_LE(choice.position, 1.0f);
  }
}

TEST(ImportanceTables, CellsArePartitionsOfPositiveSize) {
  for (const BrdfTable& brdf : {lambert(), mirror(), lobe(0.01, 0.01f), black(), lopsided()}) {
    const BrdfTables tables = compute_brdf_tables(brdf);
    for (std::size_t e = 0; e < kElevationCount; ++e) {
      float end = 0.0f;
      for (std::size_t k = 0; k < kThetaCellCount; ++k) {
        const glm::vec2 cell = tables.theta_cells[e * kThetaCellCount + k];
        ASSERT_EQ(cell.x, end);
        ASSERT_GT(cell.y, cell.x);
        end = cell.y;
        float phi = 0.0f;
        for (std::size_t p = 0; p < kPhiCellCount; ++p) {
          const glm::vec2 phi_cell = tables.phi_cells[(e * kThetaCellCount + k) * kPhiCellCount + p];
          ASSERT_EQ(phi_cell.x, phi);
          ASSERT_GT(phi_cell.y, phi_cell.x);
          phi = phi_cell.y;
        }
        ASSERT_LE(phi, 3.141593f);
      }
      ASSERT_LE(end, 1.0f);
    }
  }
}

/// Every light direction above the horizon can be drawn: the estimator is unbiased.
TEST(ImportanceTables, EveryDirectionAboveTheHorizonHasDensity) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const BrdfTable& brdf : {mirror(), lobe(0.02, 0.0f)}) {
    const BrdfTables tables = compute_brdf_tables(brdf);
    BrdfSampler sampler(tables);
    for (int i = 0; i < 20000; ++i) {
      const glm::vec3 wo(direction(kHalfPi * std::sqrt(unit(random)), 2.0 * std::numbers::pi * unit(random)));
      const glm::vec3 wi(direction(std::acos(unit(random)), 2.0 * std::numbers::pi * unit(random)));
      if (wo.z < 1e-3f || wi.z < 1e-3f) continue;
      const glm::vec3 h = glm::normalize(wi + wo);
      const int elevation = sampler.brdf_elevation(wo);
      const float t = 1.0f - h.z;
      ASSERT_LE(t, sampler.fetch_theta_cell(elevation, kThetaCellCount - 1).y * 1.0001f);
      const float phi =
          std::acos(std::clamp(glm::dot(glm::normalize(glm::vec2(h)), glm::normalize(glm::vec2(wo))), -1.0f, 1.0f));
      for (int k = 0; k < kThetaCellCount; ++k) {
        const glm::vec2 cell = sampler.fetch_theta_cell(elevation, k);
        if (t >= cell.x && t < cell.y) {
          EXPECT_LE(phi, sampler.fetch_phi_cell(elevation, k, kPhiCellCount - 1).y + 2e-3f) << "t " << t;
        }
      }
      EXPECT_GT(sampler.brdf_sample_pdf(wo, wi), 0.0f);
    }
  }
}

/// Chi-square of samples against the integrated density over bins of wi (cos theta, phi). The threshold is five
/// standard deviations of the statistic, seeds are fixed.
void expect_chi_square(const BrdfTable& brdf, double theta_o, double phi_o) {
  constexpr int kTableThetaBins = 16, kPhiBins = 24, kSub = 24, kSamples = 200000;
  const BrdfTables tables = compute_brdf_tables(brdf);
  BrdfSampler sampler(tables);
  const glm::vec3 wo(direction(theta_o, phi_o));
  std::vector<double> expected(kTableThetaBins * kPhiBins, 0.0), counted(expected.size(), 0.0);
  double expected_all = 0.0;
  for (int i = 0; i < kTableThetaBins * kSub; ++i) {
    for (int j = 0; j < kPhiBins * kSub; ++j) {
      const double z = (i + 0.5) / (kTableThetaBins * kSub), phi = 2.0 * std::numbers::pi * (j + 0.5) / (kPhiBins * kSub);
      const glm::vec3 wi(direction(std::acos(z), phi));
      const double mass = static_cast<double>(sampler.brdf_sample_pdf(wo, wi)) * 2.0 * std::numbers::pi /
                          (kTableThetaBins * kSub * kPhiBins * kSub);
      expected[static_cast<std::size_t>(i / kSub * kPhiBins + j / kSub)] += mass * kSamples;
      expected_all += mass * kSamples;
    }
  }
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  double invalid = 0.0;
  for (int s = 0; s < kSamples; ++s) {
    const auto sample = sampler.sample_brdf(wo, glm::vec2(unit(random), unit(random)));
    if (!(sample.pdf > 0.0f)) {
      invalid += 1.0;
      continue;
    }
    ASSERT_NEAR(glm::length(sample.wi), 1.0f, 1e-5f);
    const int i = std::min(static_cast<int>(sample.wi.z * kTableThetaBins), kTableThetaBins - 1);
    double phi = std::atan2(sample.wi.y, sample.wi.x);
    if (phi < 0.0) phi += 2.0 * std::numbers::pi;
    counted[static_cast<std::size_t>(
        i * kPhiBins + std::min(static_cast<int>(phi / (2.0 * std::numbers::pi) * kPhiBins), kPhiBins - 1))] += 1.0;
  }
  EXPECT_NEAR(expected_all + invalid, kSamples, 0.01 * kSamples);
  double statistic = 0.0;
  int freedom = -1;
  double rest_expected = 0.0, rest_counted = 0.0;
  const auto add = [&](double e, double c) {
    // The density is a step function, so its quadrature is off by up to 2 % in a bin that an edge crosses.
    statistic += (c - e) * (c - e) / (e + 4e-4 * e * e);
    ++freedom;
  };
  for (std::size_t b = 0; b < expected.size(); ++b) {
    if (expected[b] < 20.0) {
      rest_expected += expected[b];
      rest_counted += counted[b];
    } else {
      add(expected[b], counted[b]);
    }
  }
  if (rest_expected > 20.0) add(rest_expected, rest_counted);
  EXPECT_LT(statistic, freedom + 5.0 * std::sqrt(2.0 * freedom)) << "theta_o " << theta_o << ", freedom " << freedom;
}

TEST(Sampler, ChiSquareOfLambert) {
  for (double theta_o : {0.02, 0.7, 1.45}) expect_chi_square(lambert(), theta_o, 0.4);
}
TEST(Sampler, ChiSquareOfAWideLobe) {
  for (double theta_o : {0.3, 1.1}) expect_chi_square(lobe(0.2, 0.02f), theta_o, 4.0);
}
TEST(Sampler, ChiSquareOfALopsidedTable) { expect_chi_square(lopsided(), 0.9, 2.0); }

/// A narrow lobe is tested in its own coordinates: the cells of theta_h, and phi_h, are sampled in proportion to their
/// mass.
TEST(Sampler, ChiSquareOfANarrowLobeAndAMirrorOverCells) {
  for (const BrdfTable& brdf : {mirror(), lobe(0.004, 0.01f)}) {
    const BrdfTables tables = compute_brdf_tables(brdf);
    BrdfSampler sampler(tables);
    const glm::vec3 wo(direction(0.8, 1.0));
    const int elevation = sampler.brdf_elevation(wo);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> unit(0.0f, 1.0f);
    constexpr int kSamples = 200000;
    std::vector<double> counted(kThetaCellCount, 0.0);
    double invalid = 0.0;
    for (int s = 0; s < kSamples; ++s) {
      const auto sample = sampler.sample_brdf(wo, glm::vec2(unit(random), unit(random)));
      if (!(sample.pdf > 0.0f)) {
        invalid += 1.0;
        continue;
      }
      const glm::dvec3 sum = glm::dvec3(sample.wi) + glm::dvec3(wo);
      const double tangent_squared = (sum.x * sum.x + sum.y * sum.y) / (sum.z * sum.z);
      // 1 - cos by its series, where the subtraction would cancel.
      const double exact = tangent_squared < 1e-3 ? 0.5 * tangent_squared * (1.0 - 0.75 * tangent_squared)
                                                  : 1.0 - sum.z / glm::length(sum);
      for (int k = 0; k < kThetaCellCount; ++k) {
        if (exact < static_cast<double>(sampler.fetch_theta_cell(elevation, k).y) || k == kThetaCellCount - 1) {
          counted[static_cast<std::size_t>(k)] += 1.0;
          break;
        }
      }
    }
    EXPECT_LT(invalid, 0.03 * kSamples);
    // The half vector is recomputed from float directions (error 1e-7 rad), so eight cells of the mirror's lobe are
    // merged into one bin.
    double statistic = 0.0;
    int freedom = 0;
    for (int k = 0; k < 80; k += 8) {
      double e = 0.0, c = 0.0;
      for (int i = k; i < k + 8; ++i) {
        e += static_cast<double>(sampler.theta_cell_mass(i)) * kSamples;
        c += counted[static_cast<std::size_t>(i)];
      }
      statistic += (c - e) * (c - e) / (e + 4e-6 * e * e);
      ++freedom;
    }
    EXPECT_LT(statistic, freedom + 5.0 * std::sqrt(2.0 * freedom));
  }
}

TEST(Sampler, CellsAreTheLastThatHaveBegun) {
  const BrdfTables tables = compute_brdf_tables(lobe(0.05, 0.02f));
  const auto expect_last = [](const glm::vec2* cells, int count, const auto& find) {
    const auto last = [&](float at) {
      int k = 0;
      while (k + 1 < count && cells[k + 1].x <= at) ++k;
      return k;
    };
    for (int k = 0; k < count; ++k)
      for (float at : {cells[k].x, std::nextafter(cells[k].x, -1.0f), 0.5f * (cells[k].x + cells[k].y), cells[k].y})
        ASSERT_EQ(find(cells, at), last(at)) << k << " " << at;
  };
  for (int elevation = 0; elevation < kElevationCount; ++elevation) {
    const int row = elevation * kThetaCellCount;
    expect_last(tables.theta_cells.data() + row, kThetaCellCount, shared::find_theta_cell);
    for (int k = 0; k < kThetaCellCount; ++k)
      expect_last(tables.phi_cells.data() + (row + k) * kPhiCellCount, kPhiCellCount, shared::find_phi_cell);
  }
}

TEST(Sampler, DensityOfASampleEqualsItsEvaluation) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  const BrdfTables tables = compute_brdf_tables(lobe(0.05, 0.02f));
  BrdfSampler sampler(tables);
  int different = 0, compared = 0;
  for (int i = 0; i < 20000; ++i) {
    const glm::vec3 wo(direction(1.5 * static_cast<double>(unit(random)), 6.28 * static_cast<double>(unit(random))));
    const auto sample = sampler.sample_brdf(wo, glm::vec2(unit(random), unit(random)));
    if (!(sample.pdf > 0.0f)) continue;
    ++compared;
    const float asked = sampler.brdf_sample_pdf(wo, sample.wi);
    if (std::abs(asked - sample.pdf) > 1e-3f * sample.pdf) ++different;  // rounding across a cell's edge
  }
  EXPECT_GT(compared, 15000);
  EXPECT_LT(different, compared / 100);
}

TEST(Albedo, LambertIsExactAtEveryElevation) {
  const BrdfTables tables = compute_brdf_tables(lambert());
  for (const glm::vec3& albedo : tables.albedo) {
    EXPECT_NEAR(albedo.x, 0.5f, 1.5e-3f);
    EXPECT_NEAR(albedo.y, 0.4f, 1.5e-3f);
    EXPECT_NEAR(albedo.z, 0.3f, 1.5e-3f);
  }
}

/// E[f cos / pdf] is the albedo by quadrature: two independent computations.
TEST(Albedo, MonteCarloThroughTheSamplerAgrees) {
  for (const BrdfTable& brdf : {lambert(), lobe(0.004, 0.05f), lobe(0.1, 0.01f), lopsided()}) {
    const BrdfTables tables = compute_brdf_tables(brdf);
    BrdfSampler sampler(tables);
    std::mt19937 random(9);
    std::uniform_real_distribution<float> unit(0.0f, 1.0f);
    for (int i : {0, 20, 45, 58}) {
      const glm::dvec3 wo = direction(i * kHalfPi / (kAlbedoCount - 1), 0.3);
      constexpr int kSamples = 20000;
      double sum = 0.0, sum_squares = 0.0;
      for (int s = 0; s < kSamples; ++s) {
        const auto sample = sampler.sample_brdf(glm::vec3(wo), glm::vec2(unit(random), unit(random)));
        if (!(sample.pdf > 0.0f)) continue;
        const double value = evaluate_brdf(brdf, glm::normalize(glm::dvec3(sample.wi)), wo).y *
                             static_cast<double>(sample.wi.z / sample.pdf);
        sum += value;
        sum_squares += value * value;
      }
      const double mean = sum / kSamples;
      const double deviation = std::sqrt(std::max(sum_squares / kSamples - mean * mean, 0.0) / kSamples);
      const double expected = static_cast<double>(tables.albedo[static_cast<std::size_t>(i)].y);
      EXPECT_NEAR(mean, expected, 4.5 * deviation + 2e-3 * expected) << "elevation " << i;
      // The importance tables match: the relative standard deviation of one sample is small (for Lambert with cosine
      // sampling it would be 0).
      EXPECT_LT(deviation * std::sqrt(kSamples) / mean, 0.5) << "elevation " << i;
    }
  }
}

TEST(Bandwidth, GaussianLobesMatchTheirClosedForm) {
  for (double degrees : {0.3, 0.5, 1.0, 2.0, 4.0, 7.0, 14.0, 28.0}) {
    const double sigma = radians(degrees);
    LocalSpectrum spectrum(8);
    std::vector<float> samples;
    for (float angle : spectrum.sample_angles()) {
      samples.push_back(static_cast<float>(
          std::exp(-0.5 * static_cast<double>(angle) * static_cast<double>(angle) / (sigma * sigma))));
    }
    spectrum.add(samples);
    // Power spectrum exp(-4 pi^2 sigma^2 nu^2): erf(2 pi sigma nu) = 0.95.
    const double closed_form = 1.38590 / (2.0 * std::numbers::pi * sigma);
    double mean = 0.0, weight_sum = 0.0;
    for (double k = 0.0; k < 2.0; k += 0.05) {
      const double weight = std::exp(-k * k);
      mean += weight * spectrum.frequency_95(k * sigma);
      weight_sum += weight;
    }
    mean /= weight_sum;
    EXPECT_GT(mean, 0.75 * closed_form) << degrees;
    EXPECT_LT(mean, 1.25 * closed_form) << degrees;
  }
}

TEST(Bandwidth, CosinesAreFoundInTheirBand) {
  for (double frequency : {1.0, 3.0, 8.0, 20.0}) {
    LocalSpectrum spectrum(2);
    std::vector<float> samples;
    for (float angle : spectrum.sample_angles()) {
      samples.push_back(static_cast<float>(std::cos(2.0 * std::numbers::pi * frequency * static_cast<double>(angle))));
    }
    spectrum.add(samples);
    for (double angle : {0.3, 0.7, 1.2}) {
      EXPECT_GT(spectrum.frequency_95(angle), 0.6 * frequency);
      EXPECT_LT(spectrum.frequency_95(angle), 2.2 * frequency);
    }
  }
}

TEST(Bandwidth, IsLocal) {
  // A narrow lobe at 0 does not raise the bandwidth at the far side of the table, nor does a diffuse base lower that of
  // the lobe.
  const std::vector<float> bandwidth = compute_bandwidth(lobe(0.004, 0.2f));
  const auto at = [&](int h) { return bandwidth[static_cast<std::size_t>(h * kThetaDCount + 30)]; };
  EXPECT_GT(at(2), 20.0f);
  EXPECT_LT(at(60), 1.0f);
}

TEST(Bandwidth, GrowsWithSharpnessAndIsLowForLambert) {
  float previous = 0.0f;
  for (double width : {0.3, 0.1, 0.03, 0.01, 0.003}) {
    const float value = compute_bandwidth(lobe(width, 0.0f))[30];
    EXPECT_GT(value, 1.5f * previous) << width;
    previous = value;
  }
  for (float value : compute_bandwidth(lambert())) EXPECT_LT(value, 0.2f);
}

TEST(Bandwidth, GgxRowsFallWithRoughness) {
  const std::vector<float> rows = ggx_bandwidth();
  ASSERT_EQ(rows.size(), std::size_t{kGgxBandwidthCount} * kThetaHCount);
  for (std::size_t i = 1; i < kGgxBandwidthCount; ++i)
    EXPECT_LE(rows[i * kThetaHCount], rows[(i - 1) * kThetaHCount] * 1.15f);
  EXPECT_GT(rows[7 * kThetaHCount], 10.0f);
  EXPECT_LT(rows[63 * kThetaHCount], 0.3f);
}

TEST(BrdfTablesCache, SecondLoadIsTheSameAndSurvivesDamage) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("maquette_tables_" + std::to_string(::getpid()));
  setenv("MAQUETTE_CACHE", folder.c_str(), 1);
  const BrdfTable brdf = lobe(0.05, 0.1f);
  const BrdfTables first = load_brdf_tables(brdf);
  ASSERT_FALSE(fs::is_empty(folder));
  const BrdfTables second = load_brdf_tables(brdf);
  EXPECT_EQ(first.theta_cells, second.theta_cells);
  EXPECT_EQ(first.phi_cells, second.phi_cells);
  EXPECT_EQ(first.albedo, second.albedo);
  EXPECT_EQ(first.bandwidth, second.bandwidth);
  for (const auto& entry : fs::directory_iterator(folder))
    fs::resize_file(entry.path(), fs::file_size(entry.path()) / 2);
  EXPECT_EQ(load_brdf_tables(brdf).albedo, first.albedo);
  unsetenv("MAQUETTE_CACHE");
  fs::remove_all(folder);
}

}  // namespace
