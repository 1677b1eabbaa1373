#include "render/reference/packed_brdf.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "render/large_pages.h"
#include "render/rgb9e5_shared.h"

namespace maquette {

namespace {

constexpr int kThetaDBricks = kThetaDCount / 2, kPhiDBricks = kPhiDCount / 4;
static_assert(kThetaHCount % 2 == 0 && kThetaDCount % 2 == 0 && kPhiDCount % 4 == 0);

/// Places of an entry are sums of one for each axis: (brick, in the brick).
constexpr int of_theta_h(int i) { return i / 2 * (kThetaDBricks * kPhiDBricks * 16) + i % 2 * 8; }
constexpr int of_theta_d(int i) { return i / 2 * (kPhiDBricks * 16) + i % 2 * 4; }
constexpr int of_phi_d(int i) { return i / 4 * 16 + i % 4; }

}  // namespace

PackedBrdf::PackedBrdf(const BrdfTable& table) : bricks_(table.rgb.size() / 16) {
  float largest = 0.0f;
  for (const glm::vec3& f : table.rgb) largest = std::max({largest, f.x, f.y, f.z});
  // The largest value has the largest exponent, even if its mantissa is rounded up.
  bias_ = largest > 0.0f ? std::clamp(31 - (std::ilogb(largest) - 7), -60, 120) : 0;
  tbb::parallel_for(0, kThetaHCount, [&](int h) {
    for (int d = 0; d < kThetaDCount; ++d)
      for (int phi = 0; phi < kPhiDCount; ++phi) {
        const auto place = static_cast<std::size_t>(of_theta_h(h) + of_theta_d(d) + of_phi_d(phi));
        bricks_[place / 16].words[place % 16] =
            shared::pack_rgb9e5(table.rgb[static_cast<std::size_t>(shared::merl_index(h, d, phi))], bias_);
      }
  });
  prefer_large_pages(bricks_);
}

/// Upper corners of phi_d come second, of theta_d third and of theta_h last.
std::array<const std::uint32_t*, 8> PackedBrdf::corners_of(const shared::MerlCell& cell) const {
  const std::uint32_t* words = bricks_.front().words.data();
  const int h[2] = {of_theta_h(cell.lower.x), of_theta_h(cell.upper.x)};
  const int d[2] = {of_theta_d(cell.lower.y), of_theta_d(cell.upper.y)};
  const int phi[2] = {of_phi_d(cell.lower.z), of_phi_d(cell.upper.z)};
  std::array<const std::uint32_t*, 8> corners;
  for (std::size_t i = 0; i < 8; ++i) corners[i] = words + h[i / 4] + d[i / 2 % 2] + phi[i % 2];
  return corners;
}

void PackedBrdf::prefetch(const shared::MerlCell& cell) const {
  for (const std::uint32_t* corner : corners_of(cell)) __builtin_prefetch(corner);
}

glm::vec3 PackedBrdf::look_up(const shared::MerlCell& cell) const {
  const std::array<const std::uint32_t*, 8> corners = corners_of(cell);
  const glm::vec3 &f = cell.fraction, g = glm::vec3(1.0f) - f;
  const float low = g.x * g.y, middle = g.x * f.y, high = f.x * g.y, highest = f.x * f.y;
  alignas(32) const float weights[8] = {low * g.z,  low * f.z,  middle * g.z,  middle * f.z,
                                        high * g.z, high * f.z, highest * g.z, highest * f.z};
  // In lanes: as unpack_rgb9e5, with signed numbers, which convert sooner.
  alignas(32) std::int32_t words[8];
  for (std::size_t i = 0; i < 8; ++i) words[i] = static_cast<std::int32_t>(*corners[i]);
  alignas(32) float red[8], green[8], blue[8];
  const int exponent = 127 - bias_;
  for (std::size_t i = 0; i < 8; ++i) {
    const std::int32_t e = (words[i] >> 27 & 31) + exponent;
    const float scale = std::bit_cast<float>(e << 23) * weights[i];
    red[i] = static_cast<float>(words[i] & 511) * scale;
    green[i] = static_cast<float>(words[i] >> 9 & 511) * scale;
    blue[i] = static_cast<float>(words[i] >> 18 & 511) * scale;
  }
  const auto sum = [](const float* v) { return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7])); };
  return {sum(red), sum(green), sum(blue)};
}

}  // namespace maquette
