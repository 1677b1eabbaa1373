#include "render/reference/packed_brdf.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>


namespace maquette {

namespace {

constexpr int kThetaDBricks = kThetaDCount / 2, kPhiDBricks = kPhiDCount / 2;
static_assert(kThetaHCount % 2 == 0 && kThetaDCount % 2 == 0 && kPhiDCount % 2 == 0);

/// Places of an entry are sums of one for each axis: (brick, in the brick).
constexpr int of_theta_h(int i) { return i / 2 * (kThetaDBricks * kPhiDBricks * 8) + i % 2 * 4; }
constexpr int of_theta_d(int i) { return i / 2 * (kPhiDBricks * 8) + i % 2 * 2; }
constexpr int of_phi_d(int i) { return i / 2 * 8 + i % 2; }

constexpr int kFloatBias = 127, kDoubleBias = 1023;  ///< of exponents

}  // namespace

PackedBrdf::Entry PackedBrdf::pack(const glm::vec3& f) {
  const float largest = std::max({f.x, f.y, f.z});
  if (!(largest > 0.0f)) return {};
  // A unit is a normal float.
  const int exponent =
      std::max(static_cast<int>(std::bit_cast<std::uint32_t>(largest) >> 23) - kFloatBias - 15, 1 - kFloatBias);
  const auto units = std::bit_cast<double>(static_cast<std::uint64_t>(kDoubleBias - exponent) << 52);  // 2^-exponent
  const auto mantissa = [&](float v) {
    return static_cast<std::uint32_t>(std::min(static_cast<double>(std::max(v, 0.0f)) * units + 0.5, 65535.0));
  };
  return {mantissa(f.x) | mantissa(f.y) << 16, mantissa(f.z) | static_cast<std::uint32_t>(exponent + kFloatBias) << 16};
}

PackedBrdf::PackedBrdf(const BrdfTable& table) {
  bricks_.resize(table.rgb.size() / 8);
  tbb::parallel_for(0, kThetaHCount, [&](int h) {
    for (int d = 0; d < kThetaDCount; ++d)
      for (int phi = 0; phi < kPhiDCount; ++phi) {
        const auto place = static_cast<std::size_t>(of_theta_h(h) + of_theta_d(d) + of_phi_d(phi));
        bricks_[place / 8].entries[place % 8] =
            pack(table.rgb[static_cast<std::size_t>(shared::merl_index(h, d, phi))]);
      }
  });
}

/// Upper corners of phi_d come second, of theta_d third and of theta_h last.
std::array<const PackedBrdf::Entry*, 8> PackedBrdf::corners_of(const shared::MerlCell& cell) const {
  const Entry* entries = bricks_.front().entries.data();
  const int h[2] = {of_theta_h(cell.lower.x), of_theta_h(cell.upper.x)};
  const int d[2] = {of_theta_d(cell.lower.y), of_theta_d(cell.upper.y)};
  const int phi[2] = {of_phi_d(cell.lower.z), of_phi_d(cell.upper.z)};
  std::array<const Entry*, 8> corners;
  for (std::size_t i = 0; i < 8; ++i) corners[i] = entries + h[i / 4] + d[i / 2 % 2] + phi[i % 2];
  return corners;
}

void PackedBrdf::prefetch(const shared::MerlCell& cell) const {
  for (const Entry* corner : corners_of(cell)) __builtin_prefetch(corner);
}

glm::vec3 PackedBrdf::look_up(const shared::MerlCell& cell) const {
  const std::array<const Entry*, 8> corners = corners_of(cell);
  const glm::vec3 &f = cell.fraction, g = glm::vec3(1.0f) - f;
  const float low = g.x * g.y, middle = g.x * f.y, high = f.x * g.y, highest = f.x * f.y;
  alignas(32) const float weights[8] = {low * g.z,  low * f.z,  middle * g.z,  middle * f.z,
                                        high * g.z, high * f.z, highest * g.z, highest * f.z};
  // In lanes, with signed numbers, which convert sooner.
  alignas(32) std::int32_t first[8], second[8];
  for (std::size_t i = 0; i < 8; ++i) {
    first[i] = static_cast<std::int32_t>(corners[i]->red_green);
    second[i] = static_cast<std::int32_t>(corners[i]->blue_exponent);
  }
  alignas(32) float red[8], green[8], blue[8];
  for (std::size_t i = 0; i < 8; ++i) {
    const float scale = std::bit_cast<float>((second[i] >> 16) << 23) * weights[i];
    red[i] = static_cast<float>(first[i] & 65535) * scale;
    green[i] = static_cast<float>(first[i] >> 16 & 65535) * scale;
    blue[i] = static_cast<float>(second[i] & 65535) * scale;
  }
  const auto sum = [](const float* v) { return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7])); };
  return {sum(red), sum(green), sum(blue)};
}

}  // namespace maquette
