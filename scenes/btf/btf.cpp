#include "scenes/btf/btf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "scenes/btf/half_floats.h"
#include "scenes/files.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr std::size_t kMostFloats = 3 * (1 + static_cast<std::size_t>(kMostBtfComponents));

/// Adds `share` times the factors of a texel.
void add_texel(const std::uint16_t* texel, float share, std::size_t count, float* sum) {
#pragma omp simd
  for (std::size_t i = 0; i < count; ++i) sum[i] += share * float_of_half(texel[i]);
}

/// Bilinear between texel centres, wrapping.
void add_level(const BtfView& view, const BtfLevel& level, const glm::vec2& uv, float share, std::size_t count,
               float* sum) {
  const auto wrap = [](int i, int n) { return i < 0 ? i + n : i >= n ? i - n : i; };
  const glm::vec2 tile = uv - glm::floor(uv);
  const float x = tile.x * static_cast<float>(level.width) - 0.5f, y = tile.y * static_cast<float>(level.height) - 0.5f;
  const float left = std::floor(x), top = std::floor(y), fx = x - left, fy = y - top;
  const int x0 = wrap(static_cast<int>(left), level.width), x1 = wrap(x0 + 1, level.width);
  const int y0 = wrap(static_cast<int>(top), level.height), y1 = wrap(y0 + 1, level.height);
  const std::uint16_t* texels = view.factors.data() + level.offset;
  const auto at = [&](int column, int row) {
    return texels +
           (static_cast<std::size_t>(row) * static_cast<std::size_t>(level.width) + static_cast<std::size_t>(column)) *
               count;
  };
  add_texel(at(x0, y0), share * (1.0f - fx) * (1.0f - fy), count, sum);
  add_texel(at(x1, y0), share * fx * (1.0f - fy), count, sum);
  add_texel(at(x0, y1), share * (1.0f - fx) * fy, count, sum);
  add_texel(at(x1, y1), share * fx * fy, count, sum);
}

/// Place and size of level `index`, without the list of all.
BtfLevel level_at(const Btf& btf, int index) {
  BtfLevel level{btf.width, btf.height, 0};
  const std::size_t floats = 3 * (1 + static_cast<std::size_t>(btf.components));
  for (int i = 0; i < index; ++i) {
    level.offset += static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height) * floats;
    level.width = std::max(1, level.width / 2);
    level.height = std::max(1, level.height / 2);
  }
  return level;
}

int last_level(const Btf& btf) {
  int last = 0;
  for (int side = std::max(btf.width, btf.height); side > 1; side /= 2) ++last;
  return last;
}

void read_floats(const Btf& btf, const BtfView& view, const BtfLookup& at, float* sum) {
  const std::size_t count = 3 * (1 + static_cast<std::size_t>(btf.components));
  std::fill_n(sum, count, 0.0f);
  const float texels = at.footprint * static_cast<float>(std::max(btf.width, btf.height));
  const float place = std::min(texels > 1.0f ? std::log2(texels) : 0.0f, static_cast<float>(last_level(btf)));
  const int fine = static_cast<int>(place);
  const float coarse_share = place - static_cast<float>(fine);
  add_level(view, level_at(btf, fine), at.uv, 1.0f - coarse_share, count, sum);
  if (coarse_share > 0.0f) add_level(view, level_at(btf, fine + 1), at.uv, coarse_share, count, sum);
}

/// One axis of a box filter: the texels of the finer level under one of the coarser, and their shares.
struct BoxSpan {
  int first = 0;
  std::vector<float> shares;
};
std::vector<BoxSpan> box_spans(int fine, int coarse) {
  std::vector<BoxSpan> spans;
  const double step = static_cast<double>(fine) / coarse;
  for (int i = 0; i < coarse; ++i) {
    const double begin = i * step, end = (i + 1) * step;
    BoxSpan span{static_cast<int>(begin), {}};
    for (int k = span.first; k < fine && k < end; ++k)
      span.shares.push_back(static_cast<float>((std::min(end, k + 1.0) - std::max(begin, 1.0 * k)) / step));
    spans.push_back(std::move(span));
  }
  return spans;
}

void filter_level(const BtfLevel& fine, const BtfLevel& coarse, std::size_t count,
                  std::vector<std::uint16_t>* factors) {
  const std::vector<BoxSpan> columns = box_spans(fine.width, coarse.width);
  const std::vector<BoxSpan> rows = box_spans(fine.height, coarse.height);
  std::array<float, kMostFloats> sum;
  std::uint16_t* out = factors->data() + coarse.offset;
  for (const BoxSpan& row : rows)
    for (const BoxSpan& column : columns) {
      sum.fill(0.0f);
      for (std::size_t y = 0; y < row.shares.size(); ++y)
        for (std::size_t x = 0; x < column.shares.size(); ++x) {
          const std::size_t texel = (static_cast<std::size_t>(row.first) + y) * static_cast<std::size_t>(fine.width) +
                                    static_cast<std::size_t>(column.first) + x;
          add_texel(factors->data() + fine.offset + texel * count, row.shares[y] * column.shares[x], count, sum.data());
        }
      for (std::size_t i = 0; i < count; ++i) *out++ = half_of_float(sum[i]);
    }
}

/// As files hold them.
std::vector<glm::vec3> rounded(const std::vector<glm::dvec3>& directions) {
  return {directions.begin(), directions.end()};
}

std::uint64_t hash_of(const Btf& btf) {
  const std::vector<double> numbers = {static_cast<double>(btf.width), static_cast<double>(btf.height),
                                       static_cast<double>(btf.components), btf.texel_m};
  std::uint64_t hash = content_hash(std::as_bytes(std::span(numbers)));
  const auto chain = [&](const auto& values) { hash = content_hash(std::as_bytes(std::span(values)), hash); };
  for (const BtfView& view : btf.views) {
    chain(view.light_weights);
    chain(rounded(view.lights->directions()));
    chain(view.factors);
  }
  chain(rounded(btf.view_mesh.directions()));
  return hash;
}

}  // namespace

std::vector<BtfLevel> btf_levels(int width, int height, int components) {
  std::vector<BtfLevel> levels;
  const std::size_t count = 3 * (1 + static_cast<std::size_t>(components));
  BtfLevel level{width, height, 0};
  while (true) {
    levels.push_back(level);
    if (level.width == 1 && level.height == 1) return levels;
    level.offset += static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height) * count;
    level.width = std::max(1, level.width / 2);
    level.height = std::max(1, level.height / 2);
  }
}

void read_btf_factors(const Btf& btf, const BtfView& view, const BtfLookup& at, glm::vec3* colors) {
  std::array<float, kMostFloats> sum;
  read_floats(btf, view, at, sum.data());
  for (std::size_t k = 0; k <= static_cast<std::size_t>(btf.components); ++k)
    colors[k] = {sum[3 * k], sum[3 * k + 1], sum[3 * k + 2]};
}

glm::vec3 evaluate_btf(const Btf& btf, const BtfLookup& at, const glm::vec3& wi, const glm::vec3& wo) {
  if (!(wi.z > 0.0f) || !(wo.z > 0.0f)) return glm::vec3(0.0f);
  const DirectionWeights views = btf.view_mesh.find(wo);
  const auto components = static_cast<std::size_t>(btf.components);
  glm::vec3 rho(0.0f);
  for (std::size_t k = 0; k < 3; ++k) {
    const float share = views.weight[static_cast<int>(k)];
    if (!(share > 0.0f)) continue;
    const BtfView& view = btf.views[static_cast<std::size_t>(views.index[k])];
    std::array<float, kMostFloats> factors;
    read_floats(btf, view, at, factors.data());
    glm::vec3 value(factors[0], factors[1], factors[2]);
    const DirectionWeights lights = view.lights->find(wi);
    for (std::size_t c = 0; c < components; ++c) {
      float weight = 0.0f;
      for (std::size_t l = 0; l < 3; ++l)
        weight += lights.weight[static_cast<int>(l)] *
                  view.light_weights[static_cast<std::size_t>(lights.index[l]) * components + c];
      value += weight * glm::vec3(factors[3 * c + 3], factors[3 * c + 4], factors[3 * c + 5]);
    }
    rho += share * value;
  }
  return glm::max(rho, glm::vec3(0.0f));
}

void complete_btf(Btf* btf) {
  const std::vector<BtfLevel> levels = btf_levels(btf->width, btf->height, btf->components);
  const std::size_t count = 3 * (1 + static_cast<std::size_t>(btf->components));
  parallel_for(std::size_t{0}, btf->views.size(), [&](std::size_t v) {
    std::vector<std::uint16_t>* factors = &btf->views[v].factors;
    factors->resize(levels.back().offset + count);
    for (std::size_t i = 1; i < levels.size(); ++i) filter_level(levels[i - 1], levels[i], count, factors);
  });
  std::vector<glm::dvec3> directions;
  for (const BtfView& view : btf->views) directions.push_back(view.direction);
  btf->view_mesh = DirectionMesh(std::move(directions));
  btf->hash = hash_of(*btf);
}

double btf_energy_kept(const Btf& btf, int components) {
  double kept = 0.0, all = 0.0;
  for (const BtfView& view : btf.views) {
    all += view.figures.energy;
    const auto count = std::min(static_cast<std::size_t>(components), view.figures.spectrum.size());
    for (std::size_t i = 0; i < count; ++i) kept += static_cast<double>(view.figures.spectrum[i]);
  }
  return all > 0.0 ? std::min(kept / all, 1.0) : 1.0;
}

}  // namespace maquette
