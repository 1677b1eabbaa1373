#include "render/reference/presampled_environment.h"

#include <algorithm>

#include "render/math/low_discrepancy.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr int kLeastSide = 8;
/// Most directions of the first set, for each pixel.
constexpr double kDirectionsAPixel = 0.3;

float to_unit(std::uint32_t word) { return static_cast<float>(word >> 8) * 0x1p-24f; }

}  // namespace

PresampledEnvironment::PresampledEnvironment(const EnvironmentLight& environment, int leaves, std::size_t pixels,
                                             std::uint32_t seed)
    : environment_(environment), leaves_(leaves), first_side_(kMostSide), seed_(mix_seed(seed, 0x5a3b1e5u)) {
  while (first_side_ > kLeastSide &&
         first_side_ * first_side_ * leaves_ > kDirectionsAPixel * static_cast<double>(pixels))
    first_side_ /= 2;
}

void PresampledEnvironment::prepare(std::uint32_t paths) {
  const std::size_t wanted = (std::min(paths, kMostPaths) + kPathsASet - 1) / kPathsASet;
  while (sets_.size() < wanted) sets_.push_back(draw_set(sets_.empty() ? first_side_ : kMostSide));
}

PresampledEnvironment::Set PresampledEnvironment::draw_set(int side) const {
  Set set{side, std::vector<PresampledDirection>(static_cast<std::size_t>(leaves_ * side * side))};
  const std::uint32_t seed = mix_seed(seed_, static_cast<std::uint32_t>(sets_.size()));
  parallel_for(0, leaves_ * side, [&](int line) {
    for (int column = 0; column < side; ++column) {
      const int index = line * side + column;
      const auto key = static_cast<std::uint32_t>(2 * index);
      const glm::vec2 jitter(to_unit(mix_seed(seed, key)), to_unit(mix_seed(seed, key + 1)));
      const glm::vec2 within = (glm::vec2(column, line % side) + jitter) / static_cast<float>(side);
      LightDraw draw = environment_.draw_in_leaf(line / side, glm::min(within, glm::vec2(0x1.fffffep-1f)));
      environment_.fill(&draw);
      set.samples[static_cast<std::size_t>(index)] = {draw.direction, draw.pdf, draw.radiance};
    }
  });
  return set;
}

}  // namespace maquette
