#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <random>

#include "scenes/brdf.h"
#include "scenes/error.h"
#include "scenes/files.h"

namespace {

namespace fs = std::filesystem;
using namespace maquette;

constexpr std::size_t kEntries = kBrdfEntryCount;
constexpr std::size_t kHeader = 12;

std::size_t entry(int theta_h, int theta_d, int phi_d) {
  return static_cast<std::size_t>(phi_d + kPhiDCount * (theta_d + kThetaDCount * theta_h));
}

/// A .binary in memory; values as stored in the file (before MERL's scales).
struct RawTable {
  std::vector<std::byte> bytes = std::vector<std::byte>(kHeader + 3 * kEntries * sizeof(double));
  RawTable() {
    const std::int32_t dimensions[3] = {90, 90, 180};
    std::memcpy(bytes.data(), dimensions, sizeof dimensions);
    fill([](int, int, int) { return 150.0; });
  }
  void set(std::size_t index, double value) {
    for (std::size_t c = 0; c < 3; ++c) {
      std::memcpy(bytes.data() + kHeader + (c * kEntries + index) * sizeof(double), &value, sizeof value);
    }
  }
  void fill(const std::function<double(int, int, int)>& value) {
    for (int h = 0; h < kThetaHCount; ++h) {
      for (int d = 0; d < kThetaDCount; ++d) {
        for (int p = 0; p < kPhiDCount; ++p) set(entry(h, d, p), value(h, d, p));
      }
    }
  }
};

class MerlTest : public ::testing::Test {
 protected:
  void SetUp() override {
    path_ = (fs::temp_directory_path() / ("maquette_merl_" + std::to_string(::getpid()) + ".binary")).string();
  }
  void TearDown() override { fs::remove(path_); }
  BrdfTable load(const std::vector<std::byte>& bytes) const {
    write_file_atomically(path_, bytes);
    return load_merl(path_);
  }
  /// One line that names the file; the message must contain `part`.
  void expect_error(const std::vector<std::byte>& bytes, const std::string& part) const {
    try {
      load(bytes);
      ADD_FAILURE() << "no error; expected: " << part;
    } catch (const Error& error) {
      const std::string text = error.what();
      EXPECT_NE(text.find(part), std::string::npos) << text;
      EXPECT_EQ(text.find(path_), 0u) << text;
      EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    }
  }
  std::string path_;
};

TEST_F(MerlTest, AppliesTheScalesAndKeepsTheOrder) {
  RawTable raw;
  raw.fill([](int h, int d, int p) { return h * 10000.0 + d * 100.0 + p * 0.5; });
  const BrdfTable table = load(raw.bytes);
  ASSERT_EQ(table.rgb.size(), kEntries);
  EXPECT_EQ(table.unmeasured_count, 0u);
  const double value = 12 * 10000.0 + 34 * 100.0 + 56 * 0.5;
  EXPECT_NEAR(table.rgb[entry(12, 34, 56)].x, value / 1500.0, 1e-4);
  EXPECT_NEAR(table.rgb[entry(12, 34, 56)].y, value * 1.15 / 1500.0, 1e-4);
  EXPECT_NEAR(table.rgb[entry(12, 34, 56)].z, value * 1.66 / 1500.0, 1e-4);
}

TEST_F(MerlTest, UnmeasuredEntriesTakeTheLastMeasuredOfTheirColumn) {
  RawTable raw;
  raw.fill([](int h, int d, int) { return d >= 60 ? -1.0 : 1500.0 * (h + 100 * d); });
  raw.set(entry(3, 0, 7), std::nan(""));
  raw.set(entry(3, 1, 7), -0.5);
  const BrdfTable table = load(raw.bytes);
  EXPECT_EQ(table.unmeasured_count, 90u * 30u * 180u + 2u);
  EXPECT_FLOAT_EQ(table.rgb[entry(5, 89, 10)].x, 5.0f + 5900.0f);
  EXPECT_FLOAT_EQ(table.rgb[entry(5, 59, 10)].x, 5.0f + 5900.0f);
  // Before the first measured value: that value.
  EXPECT_FLOAT_EQ(table.rgb[entry(3, 0, 7)].x, 3.0f + 200.0f);
  EXPECT_FLOAT_EQ(table.rgb[entry(3, 1, 7)].x, 3.0f + 200.0f);
}

TEST_F(MerlTest, OneNegativeChannelMarksTheEntry) {
  RawTable raw;
  const double negative = -1.0;
  std::memcpy(raw.bytes.data() + kHeader + (kEntries + entry(4, 5, 6)) * sizeof(double), &negative, sizeof negative);
  const BrdfTable table = load(raw.bytes);
  EXPECT_EQ(table.unmeasured_count, 1u);
  EXPECT_EQ(table.rgb[entry(4, 5, 6)], table.rgb[entry(4, 4, 6)]);
}

TEST_F(MerlTest, EmptyColumnsTakeTheirNeighbour) {
  RawTable raw;
  raw.fill([](int h, int d, int p) { return h >= 80 || p == 20 ? -1.0 : 1500.0 * (h + d); });
  const BrdfTable table = load(raw.bytes);
  EXPECT_FLOAT_EQ(table.rgb[entry(85, 30, 10)].x, 79.0f + 30.0f);
  EXPECT_FLOAT_EQ(table.rgb[entry(40, 30, 20)].x, 70.0f);  // a phi_d without any value: the next phi_d
  for (const glm::vec3& value : table.rgb) ASSERT_GE(value.x, 0.0f);
}

TEST_F(MerlTest, HashFollowsTheContent) {
  RawTable raw;
  const std::uint64_t first = load(raw.bytes).hash;
  EXPECT_EQ(load(raw.bytes).hash, first);
  raw.set(entry(1, 2, 3), 151.0);
  EXPECT_NE(load(raw.bytes).hash, first);
}

TEST_F(MerlTest, RoundTripThroughSave) {
  RawTable raw;
  raw.fill([](int h, int d, int p) { return 1.0 + h * d + p; });
  const BrdfTable table = load(raw.bytes);
  save_merl(path_, table);
  const BrdfTable again = load_merl(path_);
  for (std::size_t i = 0; i < kEntries; i += 997) EXPECT_FLOAT_EQ(again.rgb[i].y, table.rgb[i].y);
}

TEST_F(MerlTest, BadFilesGiveOneLine) {
  RawTable raw;
  expect_error({}, "has 0 bytes, too short");
  expect_error(std::vector<std::byte>(raw.bytes.begin(), raw.bytes.begin() + 7), "has 7 bytes, too short");
  expect_error(std::vector<std::byte>(raw.bytes.begin(), raw.bytes.begin() + 12), "is truncated: 12 bytes");
  expect_error(std::vector<std::byte>(raw.bytes.begin(), raw.bytes.end() - 1), "is truncated");
  auto longer = raw.bytes;
  longer.push_back(std::byte{0});
  expect_error(longer, "is too long");
  auto header = raw.bytes;
  header[0] = std::byte{89};
  expect_error(header, "89 x 90 x 180, 90 x 90 x 180 expected");
  for (std::size_t i = 0; i < 12; ++i) header[i] = std::byte{0xff};
  expect_error(header, "-1 x -1 x -1");
}

TEST_F(MerlTest, BadValuesGiveOneLine) {
  RawTable raw;
  raw.fill([](int, int, int) { return -1.0; });
  expect_error(raw.bytes, "no measured value");
  raw.fill([](int, int, int) { return std::nan(""); });
  expect_error(raw.bytes, "no measured value");
  RawTable infinite;
  infinite.set(entry(10, 20, 30), std::numeric_limits<double>::infinity());
  expect_error(infinite.bytes, "infinite");
  infinite.set(entry(10, 20, 30), 1e300);  // infinite as float
  expect_error(infinite.bytes, "infinite");
}

TEST_F(MerlTest, MissingFileAndFolderGiveOneLine) {
  EXPECT_THROW(load_merl("/no/such/file.binary"), Error);
  EXPECT_THROW(load_merl(fs::temp_directory_path().string()), Error);
}

TEST(EvaluateBrdf, ReturnsEntriesAtBinCentresAndIsReciprocal) {
  BrdfTable table;
  table.rgb.resize(kEntries);
  for (std::size_t i = 0; i < kEntries; ++i) table.rgb[i] = glm::vec3(static_cast<float>(i % 1009));
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int compared = 0;
  for (int i = 0; i < 3000; ++i) {
    const int h = static_cast<int>(60 * unit(random)), d = static_cast<int>(80 * unit(random)),
              p = static_cast<int>(180 * unit(random));
    const double theta_h = std::pow((h + 0.5) / 90.0, 2) * glm::half_pi<double>();
    const double theta_d = (d + 0.5) / 90.0 * glm::half_pi<double>(), phi_d = (p + 0.5) / 180.0 * glm::pi<double>();
    const glm::dvec3 local(std::sin(theta_d) * std::cos(phi_d), std::sin(theta_d) * std::sin(phi_d), std::cos(theta_d));
    const auto rotated = [&](const glm::dvec3& v) {  // rotate z to the half vector
      return glm::dvec3(v.x * std::cos(theta_h) + v.z * std::sin(theta_h), v.y,
                        -v.x * std::sin(theta_h) + v.z * std::cos(theta_h));
    };
    const glm::dvec3 wi = rotated(local), wo = rotated({-local.x, -local.y, local.z});
    if (wi.z <= 0.01 || wo.z <= 0.01) continue;
    ++compared;
    const double expected = static_cast<double>(table.rgb[entry(h, d, p)].x);
    EXPECT_NEAR(evaluate_brdf(table, wi, wo).x, expected, 1e-6);
    EXPECT_NEAR(evaluate_brdf(table, wo, wi).x, expected, 1e-6);
  }
  EXPECT_GT(compared, 500);
  EXPECT_EQ(evaluate_brdf(table, {0.6, 0.0, -0.8}, {0.0, 0.0, 1.0}), glm::dvec3(0.0));
}

}  // namespace
