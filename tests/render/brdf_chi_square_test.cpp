// Chi-square tests of the sampler of measured tables: every built-in material and special tables, in every row of view
// elevations. Bins are of the half vector, with their own edges inside the sampler's cells; the expected counts are the
// integral of the density of brdf_sample_pdf, which is constant over solid angle of h within a cell.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "render/materials/brdf_sampler.h"
#include "render/materials/symmetric_brdf.h"
#include "tests/support/chi_square.h"

namespace {

using namespace maquette;
using shared::BrdfSampler;

constexpr int kPhiSlices = 6;    // of [0, pi], on each side of the plane of view and normal
constexpr int kCellsPerBin = 4;  // of theta
constexpr int kThetaBins = kThetaCellCount / kCellsPerBin + 1;

struct NamedTable {
  std::string name;
  BrdfTable table;
};

BrdfTable grey_table(const std::function<double(double, double, double)>& f) {
  BrdfTable table;
  table.rgb.reserve(kBrdfEntryCount);
  for (int h = 0; h < kThetaHCount; ++h)
    for (int d = 0; d < kThetaDCount; ++d)
      for (int p = 0; p < kPhiDCount; ++p)
        table.rgb.emplace_back(static_cast<float>(
            f(theta_h_of_bin_edge(h + 0.5), (d + 0.5) / 90.0 * kHalfPi, (p + 0.5) / 180.0 * std::numbers::pi)));
  return table;
}

std::vector<NamedTable> adversarial_tables() {
  std::vector<NamedTable> tables;
  tables.push_back({"black", grey_table([](double, double, double) { return 0.0; })});
  tables.push_back({"mirror", grey_table([](double h, double, double) { return h < 3e-4 ? 1e6 : 0.0; })});
  tables.push_back({"two needles", grey_table([](double h, double d, double) {
                      return (h < 3e-4 ? 1e5 : 0.0) + (std::abs(h - 0.6) < 0.01 && d > 1.0 ? 1e3 : 1e-4);
                    })});
  tables.push_back({"retro", grey_table([](double, double d, double) { return d < 0.1 ? 30.0 : 1e-3; })});
  tables.push_back({"only grazing", grey_table([](double h, double d, double) { return h + d > 1.5 ? 50.0 : 0.0; })});
  tables.push_back({"one azimuth", grey_table([](double, double, double p) { return p < 0.02 ? 100.0 : 0.0; })});
  std::mt19937 random(test::test_seed(5));
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  tables.push_back({"noise of 12 decades",
                    grey_table([&](double, double, double) { return std::pow(10.0, 12.0 * unit(random) - 8.0); })});
  tables.push_back({"one hot entry", grey_table([](double, double, double) { return 1e-3; })});
  tables.back().table.rgb[90 + kPhiDCount * (80 + kThetaDCount * 20)] = glm::vec3(1e6f);
  return tables;
}

/// View and normal in the half vector's frame: azimuth 0, along x, is that of the view.
struct View {
  glm::dvec3 wo{};
  glm::dvec2 azimuth{};
};

View view_at(double theta, double phi) {
  const glm::dvec2 azimuth(std::cos(phi), std::sin(phi));
  // Rounded in the same way as in the sampler.
  const glm::dvec3 exact(std::sin(theta) * azimuth.x, std::sin(theta) * azimuth.y, std::cos(theta));
  const glm::dvec3 wo{glm::vec3(exact)};
  return {wo, azimuth};
}

glm::dvec3 light_of(const View& view, double t, double phi) {
  const double s = std::sqrt(t * (2.0 - t)), x = s * std::cos(phi), y = s * std::sin(phi);
  const glm::dvec3 h(x * view.azimuth.x - y * view.azimuth.y, x * view.azimuth.y + y * view.azimuth.x, 1.0 - t);
  return 2.0 * glm::dot(view.wo, h) * h - view.wo;
}

struct SamplerBins {
  std::array<double, kThetaBins + 1> t{};
  SamplerBins(BrdfSampler& sampler, int elevation) {
    for (std::size_t i = 1; i < kThetaBins; ++i) {
      const glm::vec2 cell = sampler.fetch_theta_cell(elevation, kCellsPerBin * (static_cast<int>(i) - 1));
      t[i] = static_cast<double>(cell.x) + 0.37 * static_cast<double>(cell.y - cell.x);
    }
    t[kThetaBins] = 1.0;
  }
  std::size_t index(double at, double phi) const {
    const auto i = static_cast<std::size_t>(std::upper_bound(t.begin() + 1, t.end() - 1, at) - t.begin() - 1);
    const double side = phi < 0.0 ? 1.0 : 0.0;
    const double slice = std::min(std::floor(std::abs(phi) / std::numbers::pi * kPhiSlices), kPhiSlices - 1.0);
    return (i * 2 + static_cast<std::size_t>(side)) * kPhiSlices + static_cast<std::size_t>(slice);
  }
  static constexpr std::size_t kCount = std::size_t{kThetaBins} * 2 * kPhiSlices;
};

/// Integral of the density over a piece of a cell, on one side; split where the horizon crosses it.
double piece_mass(BrdfSampler& sampler, const View& view, const glm::dvec2& t, const glm::dvec2& phi) {
  int above = 0;
  for (int k = 0; k < 9; ++k) {
    const double ti = glm::mix(t.x, t.y, 0.5 * (k % 3)), pi = glm::mix(phi.x, phi.y, 0.5 * (k / 3));
    const double margin = 0.02 * std::abs(phi.y - phi.x) + 1e-6;
    above += light_of(view, ti, pi).z > margin ? 1 : light_of(view, ti, pi).z < -margin ? -1 : 0;
  }
  if (above == -9) return 0.0;
  const int n = above == 9 ? 1 : 24;
  double sum = 0.0;
  for (int i = 0; i < n * n; ++i) {
    const double ti = glm::mix(t.x, t.y, (i % n + 0.5) / n), pi = glm::mix(phi.x, phi.y, (i / n + 0.5) / n);
    const glm::dvec3 wi = light_of(view, ti, pi);
    const double projection = 0.5 * glm::length(wi + view.wo);
    sum += static_cast<double>(sampler.brdf_sample_pdf(glm::vec3(view.wo), glm::vec3(wi))) * 4.0 * projection;
  }
  return sum / (n * n) * (t.y - t.x) * (phi.y - phi.x);
}

void add_expected(BrdfSampler& sampler, const View& view, const SamplerBins& bins, double samples,
                  std::vector<double>* expected) {
  const int elevation = sampler.brdf_elevation(glm::vec3(view.wo));
  const auto cut = [](double begin, double end, const auto& knots) {
    std::vector<double> cuts{begin};
    for (const double knot : knots)
      if (knot > begin && knot < end) cuts.push_back(knot);
    cuts.push_back(end);
    return cuts;
  };
  std::array<double, kPhiSlices + 1> slices{};
  for (std::size_t i = 0; i < slices.size(); ++i) slices[i] = std::numbers::pi * static_cast<double>(i) / kPhiSlices;
  for (int k = 0; k < kThetaCellCount; ++k) {
    const glm::dvec2 cell(sampler.fetch_theta_cell(elevation, k));
    const std::vector<double> ts = cut(cell.x, cell.y, bins.t);
    for (int p = 0; p < kPhiCellCount; ++p) {
      const glm::dvec2 phi_cell(sampler.fetch_phi_cell(elevation, k, p));
      const std::vector<double> phis = cut(phi_cell.x, phi_cell.y, slices);
      for (std::size_t i = 0; i + 1 < ts.size(); ++i) {
        for (std::size_t j = 0; j + 1 < phis.size(); ++j) {
          const double mass = samples * piece_mass(sampler, view, {ts[i], ts[i + 1]}, {phis[j], phis[j + 1]});
          const double middle_t = 0.5 * (ts[i] + ts[i + 1]), middle_phi = 0.5 * (phis[j] + phis[j + 1]);
          (*expected)[bins.index(middle_t, middle_phi)] += mass;
          (*expected)[bins.index(middle_t, -middle_phi)] += mass;
        }
      }
    }
  }
}

/// Tests one row of elevations with one view inside it. Returns p.
test::ChiSquare test_view(BrdfSampler& sampler, const View& view, std::uint32_t seed, std::size_t samples) {
  const SamplerBins bins(sampler, sampler.brdf_elevation(glm::vec3(view.wo)));
  std::vector<double> expected(SamplerBins::kCount + 1, 0.0), counted(expected.size(), 0.0);
  add_expected(sampler, view, bins, static_cast<double>(samples), &expected);
  double inside = 0.0;
  for (const double e : expected) inside += e;
  expected.back() = std::max(static_cast<double>(samples) - inside, 0.0);  // below the horizon
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (std::size_t s = 0; s < samples; ++s) {
    const auto sample = sampler.sample_brdf(glm::vec3(view.wo), glm::vec2(unit(random), unit(random)));
    if (!(sample.pdf > 0.0f)) {
      counted.back() += 1.0;
      continue;
    }
    const glm::dvec3 sum = glm::dvec3(sample.wi) + view.wo;
    const double xy = sum.x * sum.x + sum.y * sum.y, length = glm::length(sum);
    const double t = xy / (length * (length + sum.z));
    const double c = sum.x * view.azimuth.x + sum.y * view.azimuth.y,
                 q = sum.y * view.azimuth.x - sum.x * view.azimuth.y;
    counted[bins.index(t, std::atan2(q, c))] += 1.0;
  }
  // Light directions are floats: close to the horizon the tangent of theta_h has an error of 6e-8 / cos(theta_o), a
  // tenth of a mirror's cell.
  return test::chi_square(expected, counted, 5.0, view.wo.z < 0.02 ? 0.3 : 0.0);
}

/// Every row of elevations once, at some view inside it. A campaign of a thousand runs makes six million comparisons:
/// with a false positive rate of 1e-9 per test, one campaign in about two hundred fails by chance.
void expect_rows(const NamedTable& named) {
  BrdfTables tables;
  compute_importance(SymmetricBrdf(named.table), tables);
  BrdfSampler sampler(tables);
  std::mt19937 random(test::test_seed(17));
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int row = 0; row < kElevationCount; ++row) {
    const double theta = std::min((row + unit(random)) * kHalfPi / kElevationCount, kHalfPi - 1e-4);
    const View view = view_at(theta, 2.0 * std::numbers::pi * unit(random));
    const auto result = test_view(sampler, view, static_cast<std::uint32_t>(random()), test::test_samples(6000));
    EXPECT_GT(result.p, 1e-7) << named.name << ", view at " << theta << " rad, statistic " << result.statistic << " of "
                              << result.freedom;
    EXPECT_LE(result.outside, static_cast<int>(test::test_samples(1))) << named.name << ", view at " << theta;
  }
}

TEST(BrdfChiSquare, EveryBuiltInMaterialAtEveryElevation) {
  for (const BuiltinBrdf& entry : builtin_brdfs()) expect_rows({entry.name, make_builtin_brdf(entry.name)});
}

TEST(BrdfChiSquare, TablesMadeToBreakIt) {
  for (const NamedTable& named : adversarial_tables()) expect_rows(named);
}

/// Tests the test itself: it detects a sampler that draws one cell too often.
TEST(BrdfChiSquare, FindsAWrongDensity) {
  const std::vector<double> expected(50, 200.0);
  std::vector<double> counted(expected);
  EXPECT_GT(test::chi_square(expected, counted).p, 0.99);
  counted[7] += 90.0;
  counted[8] -= 90.0;
  EXPECT_LT(test::chi_square(expected, counted).p, 0.03);
  counted[7] += 110.0;
  EXPECT_LT(test::chi_square(expected, counted).p, 1e-7);
  EXPECT_NEAR(test::chi_square({{5.0, 5.0, 5.0, 5.0}}, {{8.0, 9.0, 2.0, 1.0}}).p, 0.0185661,
              1e-6);  // statistic 10, 3 degrees of freedom
}

}  // namespace
