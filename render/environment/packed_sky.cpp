#include "render/environment/packed_sky.h"

#include <algorithm>
#include <cmath>

#include "render/math/shared_formulas.h"
#include "scenes/parallel.h"

namespace maquette {

int packing_bias(const Environment& environment) {
  float largest = 0.0f;
  for (const glm::vec3& c : environment.rgb) largest = std::max({largest, c.x, c.y, c.z});
  if (!(largest > 0.0f)) return 24;
  return std::clamp(31 - static_cast<int>(std::ceil(std::log2(largest / 511.0f))), -80, 110);
}

int sky_refinement(const Environment& environment, std::size_t most) {
  const std::size_t texels = environment.rgb.size();
  return 16 * texels <= most ? 4 : 4 * texels <= most ? 2 : 1;
}

namespace {

/// Packs values one after the other. The rounding error of one value is added to the next, as far as that changes no
/// more than the rounding of the next value (error diffusion: Floyd and Steinberg 1976). This keeps the power of lamps,
/// which equal roundings of a few nodes would shift.
class DiffusingPacker {
 public:
  explicit DiffusingPacker(int bias) : bias_(bias) {}
  std::uint32_t pack(const glm::vec3& value) {
    const float half_step = std::max({value.x, value.y, value.z}) * (1.0f / 1024.0f);  // at most
    const glm::vec3 wanted = glm::max(value + glm::clamp(owed_, -half_step, half_step), 0.0f);
    const std::uint32_t word = shared::pack_rgb9e5(wanted, bias_);
    owed_ = wanted - shared::unpack_rgb9e5(word, bias_);
    return word;
  }

 private:
  int bias_;
  glm::vec3 owed_{0.0f};
};

}  // namespace

PackedSky pack_sky(const Environment& environment, int bias, int refinement) {
  PackedSky sky;
  const int width = environment.width, height = environment.height;
  sky.columns = width * refinement;
  sky.spans = height * refinement;
  sky.bias = bias;
  const bool between = refinement > 1;
  sky.offset = between ? 0.0f : 0.5f;
  sky.last_row = between ? sky.spans : sky.spans - 1;
  const auto columns = static_cast<std::size_t>(sky.columns), from = static_cast<std::size_t>(width);
  const float step = 1.0f / static_cast<float>(refinement);
  sky.words.resize(columns * static_cast<std::size_t>(sky.last_row + 1));
  parallel_ranges<int>(0, sky.last_row + 1, 8, [&](const auto& rows) {
    std::vector<glm::vec3> row(from);
    for (int y = rows.begin(); y < rows.end(); ++y) {
      const int v = between ? y - refinement / 2 : y;  // sub-texels above the first texel's centre
      const int above = v < 0 ? 0 : v / refinement, part = v < 0 ? 0 : v % refinement;
      const float b = static_cast<float>(part) * step;
      const glm::vec3* upper = &environment.rgb[static_cast<std::size_t>(std::min(above, height - 1)) * from];
      const glm::vec3* lower = &environment.rgb[static_cast<std::size_t>(std::min(above + 1, height - 1)) * from];
      for (std::size_t x = 0; x < from; ++x) row[x] = part == 0 ? upper[x] : upper[x] * (1.0f - b) + lower[x] * b;
      std::uint32_t* words = &sky.words[static_cast<std::size_t>(y) * columns];
      if (!between) {
        for (std::size_t x = 0; x < from; ++x) words[x] = shared::pack_rgb9e5(row[x], bias);
        continue;
      }
      const auto parts = static_cast<std::size_t>(refinement);
      DiffusingPacker packer(bias);
      for (std::size_t x = 0; x < from; ++x) {
        const glm::vec3 &left = row[x], &right = row[x + 1 < from ? x + 1 : 0];
        for (std::size_t k = 0; k < parts; ++k) {
          const std::size_t column = x * parts + k + parts / 2;
          const float a = static_cast<float>(k) * step;
          const glm::vec3 value = k == 0 ? left : left * (1.0f - a) + right * a;
          words[column < columns ? column : column - columns] = packer.pack(value);
        }
      }
    }
  });
  return sky;
}

}  // namespace maquette
