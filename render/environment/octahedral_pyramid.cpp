#include "render/environment/octahedral_pyramid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "render/math/shared_formulas.h"
#include "scenes/parallel.h"

namespace maquette {
namespace {

constexpr int kTaskCount = 4;  ///< partial sums of the finest level, one per task

/// Adds rows [begin, end) of the environment to the cells, each texel as split x split parts.
void splat(const Environment& environment, int begin, int end, int split, int side, std::vector<glm::dvec4>& sums) {
  const int width = environment.width * split, height = environment.height * split;
  std::vector<glm::vec2> headings(static_cast<std::size_t>(width));  // sine and cosine of the longitude
  for (int x = 0; x < width; ++x) {
    const auto longitude = static_cast<float>(std::numbers::pi - 2.0 * std::numbers::pi * (x + 0.5) / width);
    headings[static_cast<std::size_t>(x)] = {std::sin(longitude), std::cos(longitude)};
  }
  for (int y = begin * split; y < end * split; ++y) {
    const double theta = std::numbers::pi * (y + 0.5) / height;
    const double solid_angle =
        2.0 * std::numbers::pi / width *
        (std::cos(std::numbers::pi * y / height) - std::cos(std::numbers::pi * (y + 1) / height));
    const auto sin_theta = static_cast<float>(std::sin(theta)), cos_theta = static_cast<float>(std::cos(theta));
    const glm::vec3* row =
        &environment.rgb[static_cast<std::size_t>(y / split) * static_cast<std::size_t>(environment.width)];
    for (int x = 0; x < width; ++x) {
      const glm::vec2& heading = headings[static_cast<std::size_t>(x)];
      const glm::vec2 uv = shared::octahedral_from_direction({heading.x * sin_theta, cos_theta, heading.y * sin_theta});
      const int cx = std::min(static_cast<int>(uv.x * static_cast<float>(side)), side - 1);
      const int cy = std::min(static_cast<int>(uv.y * static_cast<float>(side)), side - 1);
      sums[static_cast<std::size_t>(cy * side + cx)] += solid_angle * glm::dvec4(glm::dvec3(row[x / split]), 1.0);
    }
  }
}

}  // namespace

OctahedralPyramid::OctahedralPyramid(const Environment& environment, int max_side) {
  Level finest;
  // Cells of about the texels' solid angle, so that almost no cell stays empty.
  finest.side = std::clamp(static_cast<int>(std::bit_floor(static_cast<unsigned>(std::max(environment.width / 2, 16)))),
                           16, max_side);
  // The equator crosses 2 sides of cells: parts are at most half a cell wide, and texels of a quarter cell need no
  // split.
  const int split =
      environment.width >= 8 * finest.side ? 1 : std::max(2, 4 * finest.side / std::max(1, environment.width));
  const auto count = static_cast<std::size_t>(finest.side) * static_cast<std::size_t>(finest.side);
  std::vector<std::vector<glm::dvec4>> partial(kTaskCount, std::vector<glm::dvec4>(count, glm::dvec4(0.0)));
  parallel_for(0, kTaskCount, [&](int task) {
    splat(environment, environment.height * task / kTaskCount, environment.height * (task + 1) / kTaskCount, split,
          finest.side, partial[static_cast<std::size_t>(task)]);
  });
  finest.cells.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    glm::dvec4 sum(0.0);
    for (const auto& part : partial) sum += part[i];
    // Near the fold at a pole a cell may stay empty: it has no weight in the coarser levels and takes the radiance of
    // the texel in its direction.
    if (sum.w > 0.0) {
      finest.cells[i] = glm::vec4(glm::vec3(glm::dvec3(sum) / sum.w), static_cast<float>(sum.w));
    } else {
      const auto side = static_cast<std::size_t>(finest.side);
      const glm::vec2 uv((static_cast<float>(i % side) + 0.5f) / static_cast<float>(side),
                         (static_cast<float>(i / side) + 0.5f) / static_cast<float>(side));
      finest.cells[i] =
          glm::vec4(glm::vec3(evaluate_environment(environment, shared::direction_from_octahedral(uv))), 0.0f);
    }
  }
  levels_.push_back(std::move(finest));
  while (levels_.back().side > 2) {
    const Level& fine = levels_.back();
    Level coarse;
    coarse.side = fine.side / 2;
    for (int y = 0; y < coarse.side; ++y) {
      for (int x = 0; x < coarse.side; ++x) {
        glm::vec3 flux(0.0f);
        float solid_angle = 0.0f;
        for (int k = 0; k < 4; ++k) {
          const glm::vec4& cell = fine.cells[static_cast<std::size_t>((2 * y + k / 2) * fine.side + 2 * x + k % 2)];
          flux += glm::vec3(cell) * cell.w;
          solid_angle += cell.w;
        }
        coarse.cells.emplace_back(solid_angle > 0.0f ? flux / solid_angle : glm::vec3(0.0f), solid_angle);
      }
    }
    levels_.push_back(std::move(coarse));
  }
}

glm::vec3 OctahedralPyramid::bilinear(const Level& level, const glm::vec2& uv) {
  const float x = uv.x * static_cast<float>(level.side) - 0.5f, y = uv.y * static_cast<float>(level.side) - 0.5f;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const int last = level.side - 1;
  // Beyond an edge the map continues mirrored along that edge.
  const auto cell = [&](int cx, int cy) {
    if (cx < 0 || cx > last) {
      cx = cx < 0 ? -1 - cx : 2 * last + 1 - cx;
      cy = last - cy;
    }
    if (cy < 0 || cy > last) {
      cy = cy < 0 ? -1 - cy : 2 * last + 1 - cy;
      cx = last - cx;
    }
    return glm::vec3(level.cells[static_cast<std::size_t>(cy * level.side + cx)]);
  };
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  return glm::mix(glm::mix(cell(x0, y0), cell(x0 + 1, y0), fx), glm::mix(cell(x0, y0 + 1), cell(x0 + 1, y0 + 1), fx),
                  fy);
}

glm::vec3 OctahedralPyramid::lookup(const glm::vec3& direction, float solid_angle_sr) const {
  const glm::vec2 uv = shared::octahedral_from_direction(direction);
  const auto side = static_cast<float>(levels_.front().side);
  const float cell_sr = 12.566371f / (side * side);
  const float level = std::clamp(0.5f * std::log2(std::max(solid_angle_sr / cell_sr, 1.0f)), 0.0f,
                                 static_cast<float>(levels_.size() - 1));
  const auto fine = static_cast<std::size_t>(level);
  const float t = level - static_cast<float>(fine);
  const glm::vec3 value = bilinear(levels_[fine], uv);
  return t > 0.0f && fine + 1 < levels_.size() ? glm::mix(value, bilinear(levels_[fine + 1], uv), t) : value;
}

}  // namespace maquette
