#include "render/reference/packed_brdf.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "scenes/parallel.h"

namespace maquette {

namespace {

static_assert(std::endian::native == std::endian::little);
static_assert(kThetaHCount % 2 == 0 && kThetaDCount % 2 == 0 && kPhiDCount % 2 == 0);

constexpr int kFloatBias = 127, kDoubleBias = 1023;

}  // namespace

PackedBrdf::Entry PackedBrdf::pack(const glm::vec3& f) {
  const float largest = std::max({f.x, f.y, f.z});
  if (!(largest > 0.0f)) return {};
  // The unit has to be a normal float.
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
  parallel_for(0, kThetaHCount, [&](int h) {
    for (int d = 0; d < kThetaDCount; ++d)
      for (int phi = 0; phi < kPhiDCount; ++phi) {
        const auto index = static_cast<std::size_t>(of_theta_h(h) + of_theta_d(d) + of_phi_d(phi));
        bricks_[index / 8].entries[index % 8] =
            pack(table.rgb[static_cast<std::size_t>(shared::merl_index(h, d, phi))]);
      }
  });
}

void PackedBrdf::prefetch(const Cell& cell) const {
  const Entry* entries = bricks_.front().entries.data();
  for (std::size_t i = 0; i < 8; ++i) __builtin_prefetch(entries + cell.entry(i));
}

glm::vec3 PackedBrdf::look_up(const Cell& cell) const {
  const Entry* entries = bricks_.front().entries.data();
  const glm::vec3 &f = cell.fraction, g = glm::vec3(1.0f) - f;
  const float low = g.x * g.y, middle = g.x * f.y, high = f.x * g.y, highest = f.x * f.y;
  const float weights[8] = {low * g.z,  low * f.z,  middle * g.z,  middle * f.z,
                            high * g.z, high * f.z, highest * g.z, highest * f.z};
  // All channels in one register, with the exponent as an unused fourth: values stored one by one would go through the
  // cache before they can be loaded together.
  using Longs = std::uint64_t __attribute__((vector_size(16)));
  using Halves = std::uint16_t __attribute__((vector_size(16)));
  using Wholes = std::int32_t __attribute__((vector_size(16)));
  using Floats = float __attribute__((vector_size(16)));
  Floats sums[2] = {};
  for (std::size_t i = 0; i < 8; ++i) {
    const auto bits = std::bit_cast<std::uint64_t>(entries[cell.entry(i)]);
    const Halves halves = std::bit_cast<Halves>(Longs{bits, 0});
    const auto wholes = std::bit_cast<Wholes>(__builtin_shufflevector(halves, Halves{}, 0, 8, 1, 9, 2, 10, 3, 11));
    const float scale = std::bit_cast<float>(static_cast<std::uint32_t>(bits >> 48) << 23) * weights[i];
    sums[i % 2] += __builtin_convertvector(wholes, Floats) * scale;
  }
  const Floats sum = sums[0] + sums[1];
  return {sum[0], sum[1], sum[2]};
}

}  // namespace maquette
