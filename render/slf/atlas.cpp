#include "render/slf/atlas.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>

#include "render/slf/charts.h"
#include "scenes/error.h"

namespace maquette {

namespace {

constexpr int kGutter = 1;  ///< texels around a chart, for bilinear reads at its border
/// UVs may leave the unit square by rounding.
constexpr float kRangeTolerance = 1e-3f;

struct Place {
  int x = 0, y = 0, width = 0, height = 0;
};

/// Places rectangles so that their tops stay as low as possible.
/// Source: Jylanki 2010, "A Thousand Ways to Pack the Bin", Sec. 2.4 (skyline, bottom-left).
class Skyline {
 public:
  explicit Skyline(int width) : width_(width), tops_{{0, 0, width}} {}
  /// False when it does not fit below `height`.
  bool place(int height, Place* p) {
    std::size_t best = tops_.size();
    int best_top = height + 1;
    for (std::size_t i = 0; i < tops_.size(); ++i) {
      const int top = top_over(i, p->width);
      if (top >= 0 && top + p->height <= height && top < best_top) best = i, best_top = top;
    }
    if (best == tops_.size()) return false;
    p->x = tops_[best].x;
    p->y = best_top;
    raise(best, *p);
    return true;
  }

 private:
  struct Segment {
    int x, top, width;
  };
  int top_over(std::size_t i, int width) const {
    if (tops_[i].x + width > width_) return -1;
    int top = 0;
    for (int left = width; left > 0; ++i) {
      top = std::max(top, tops_[i].top);
      left -= tops_[i].width;
    }
    return top;
  }
  void raise(std::size_t i, const Place& p) {
    tops_.insert(tops_.begin() + static_cast<std::ptrdiff_t>(i), {p.x, p.y + p.height, p.width});
    int covered = p.width;
    while (covered > 0 && i + 1 < tops_.size()) {
      Segment& next = tops_[i + 1];
      if (next.width > covered) {
        next.x += covered, next.width -= covered;
        break;
      }
      covered -= next.width;
      tops_.erase(tops_.begin() + static_cast<std::ptrdiff_t>(i) + 1);
    }
    for (std::size_t k = 0; k + 1 < tops_.size();) {
      if (tops_[k].top == tops_[k + 1].top) {
        tops_[k].width += tops_[k + 1].width;
        tops_.erase(tops_.begin() + static_cast<std::ptrdiff_t>(k) + 1);
      } else {
        ++k;
      }
    }
  }
  int width_;
  std::vector<Segment> tops_;
};

/// Places of the charts at a density, or nothing when they do not fit.
std::vector<Place> pack(const std::vector<Chart>& charts, double density, int side) {
  std::vector<Place> places(charts.size());
  std::vector<std::size_t> order(charts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  for (std::size_t i = 0; i < charts.size(); ++i) {
    const glm::dvec2 extent = charts[i].extent * density;
    if (std::max(extent.x, extent.y) > side) return {};
    // One texel is enough for what is smaller than that: all reads clamp to it.
    places[i].width = extent.x < 1.0 && extent.y < 1.0 ? 1 : static_cast<int>(std::ceil(extent.x)) + 2 * kGutter;
    places[i].height = extent.x < 1.0 && extent.y < 1.0 ? 1 : static_cast<int>(std::ceil(extent.y)) + 2 * kGutter;
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return places[a].height > places[b].height; });
  Skyline skyline(side);
  for (std::size_t i : order)
    if (!skyline.place(side, &places[i])) return {};
  return places;
}

[[noreturn]] void fail_packing(std::size_t charts, int side) {
  const int wanted = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(charts)) * 2.0));
  throw Error("slf.texels",
              "an atlas of " + std::to_string(side) + " x " + std::to_string(side) + " texels has no room for " +
                  std::to_string(charts) + " charts",
              "ask for " + std::to_string(std::max(wanted, 2 * side)) + ", or for fewer parts (slf.parts)");
}

struct Packing {
  int side;
  double density;
  std::vector<Place> places;
};

/// The largest density with which the charts fit the side.
Packing fill_side(const std::vector<Chart>& charts, int side) {
  double area = 1e-30;
  for (const Chart& chart : charts) area += chart.extent.x * chart.extent.y;
  double low = 0.0, high = 2.0 * side / std::sqrt(area);
  std::vector<Place> best = pack(charts, low, side);
  if (best.empty()) fail_packing(charts.size(), side);
  for (int i = 0; i < 24; ++i) {
    const double middle = 0.5 * (low + high);
    std::vector<Place> places = pack(charts, middle, side);
    if (places.empty()) {
      high = middle;
    } else {
      low = middle;
      best = std::move(places);
    }
  }
  return {side, low, std::move(best)};
}

/// The smallest side, in steps of 16, that holds the charts at a density.
Packing fit_density(const std::vector<Chart>& charts, double density) {
  for (int side = 16; side <= kLargestAtlas; side = std::max(side + 16, side * 9 / 8 / 16 * 16))
    if (auto places = pack(charts, density, side); !places.empty()) return {side, density, std::move(places)};
  throw Error("slf.texels_per_m",
              std::to_string(density) + " texels a metre need an atlas of more than " + std::to_string(kLargestAtlas) +
                  " texels",
              "ask for fewer, or for fewer parts (slf.parts)");
}

/// Writes sides, texels and gutters of one chart.
class ChartWriter {
 public:
  explicit ChartWriter(LightFieldAtlas* atlas) : atlas_(*atlas) {}

  void write(const Chart& chart, const Place& place) {
    place_ = place;
    const auto id = static_cast<std::uint32_t>(atlas_.axes.size());
    atlas_.axes.push_back(glm::vec3(chart.axis));
    const std::size_t first_side = atlas_.sides.size(), first_texel = atlas_.texels.size();
    const bool single = place.width == 1 && place.height == 1;
    for (AtlasSide side : chart.sides) {
      side.chart = id;
      for (glm::vec2& p : side.at)
        p = single ? glm::vec2(place.x, place.y) + 0.5f
                   : p * static_cast<float>(atlas_.texels_per_m) + glm::vec2(place.x + kGutter, place.y + kGutter);
      atlas_.sides.push_back(side);
    }
    if (!single)
      for (std::size_t s = first_side; s < atlas_.sides.size(); ++s) add_texels(static_cast<std::uint32_t>(s));
    if (atlas_.texels.size() == first_texel) add_middle(first_side);
    fill(first_texel);
  }

 private:
  std::uint32_t& cell(int x, int y) {
    return atlas_.texel_of_cell[static_cast<std::size_t>(y) * static_cast<std::size_t>(atlas_.side) +
                                static_cast<std::size_t>(x)];
  }
  void add(std::uint32_t side, const glm::vec2& barycentric, int x, int y) {
    if (cell(x, y) != LightFieldAtlas::kNone) return;
    cell(x, y) = static_cast<std::uint32_t>(atlas_.texels.size());
    atlas_.texels.push_back({side, barycentric, static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)});
  }
  void add_texels(std::uint32_t s) {
    const auto& at = atlas_.sides[s].at;
    const glm::dvec2 a(at[0]), e1 = glm::dvec2(at[1]) - a, e2 = glm::dvec2(at[2]) - a;
    const double area = e1.x * e2.y - e1.y * e2.x;
    if (!(std::abs(area) > 1e-12)) return;
    const glm::vec2 low = glm::min(glm::min(at[0], at[1]), at[2]), high = glm::max(glm::max(at[0], at[1]), at[2]);
    for (int y = std::max(place_.y, static_cast<int>(low.y - 0.5f));
         y <= std::min(place_.y + place_.height - 1, static_cast<int>(high.y)); ++y)
      for (int x = std::max(place_.x, static_cast<int>(low.x - 0.5f));
           x <= std::min(place_.x + place_.width - 1, static_cast<int>(high.x)); ++x) {
        const glm::dvec2 d = glm::dvec2(x + 0.5, y + 0.5) - a;
        const double u = (d.x * e2.y - d.y * e2.x) / area, v = (e1.x * d.y - e1.y * d.x) / area;
        if (u < -1e-9 || v < -1e-9 || u + v > 1.0 + 1e-9) continue;
        add(s, glm::vec2(std::clamp(u, 0.0, 1.0), std::clamp(v, 0.0, 1.0 - std::clamp(u, 0.0, 1.0))), x, y);
      }
  }
  /// A chart between all texel centres gets one at the middle of its first side.
  void add_middle(std::size_t first_side) {
    const auto& at = atlas_.sides[first_side].at;
    const glm::vec2 middle = (at[0] + at[1] + at[2]) / 3.0f;
    add(static_cast<std::uint32_t>(first_side), glm::vec2(1.0f / 3.0f),
        std::clamp(static_cast<int>(middle.x), place_.x, place_.x + place_.width - 1),
        std::clamp(static_cast<int>(middle.y), place_.y, place_.y + place_.height - 1));
  }
  void fill(std::size_t first_texel) {
    std::deque<glm::ivec2> front;
    for (std::size_t t = first_texel; t < atlas_.texels.size(); ++t)
      front.emplace_back(atlas_.texels[t].x, atlas_.texels[t].y);
    static constexpr glm::ivec2 kSteps[8] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {-1, 1}, {1, -1}, {-1, -1}};
    while (!front.empty()) {
      const glm::ivec2 from = front.front();
      front.pop_front();
      for (const glm::ivec2& step : kSteps) {
        const glm::ivec2 to = from + step;
        if (to.x < place_.x || to.y < place_.y || to.x >= place_.x + place_.width || to.y >= place_.y + place_.height)
          continue;
        if (cell(to.x, to.y) != LightFieldAtlas::kNone) continue;
        cell(to.x, to.y) = cell(from.x, from.y);
        front.push_back(to);
      }
    }
  }

  LightFieldAtlas& atlas_;
  Place place_;
};

}  // namespace

std::string check_second_uvs(const FlatGeometry& g, std::size_t index) {
  const DrawItem& item = g.items[index];
  std::vector<std::array<glm::dvec2, 3>> at;
  bool differs = false;
  for (std::uint32_t i = item.first_index; i + 2 < item.first_index + item.index_count; i += 3) {
    std::array<glm::dvec2, 3> corners{};
    for (std::uint32_t k = 0; k < 3; ++k) {
      const glm::vec2& uv = g.uv1[g.indices[i + k]];
      if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) return "a coordinate is not finite";
      if (std::min(uv.x, uv.y) < -kRangeTolerance || std::max(uv.x, uv.y) > 1.0f + kRangeTolerance)
        return "a coordinate is outside the unit square";
      differs |= uv != g.uv1[g.indices[item.first_index]];
      corners[k] = uv;
    }
    at.push_back(corners);
  }
  if (!differs) return kNoSecondUvs;
  for (const ChartTriangle& t : chart_triangles(g, item, false)) {
    const auto& c = at[t.triangle - item.first_index / 3];
    const glm::dvec2 a = c[1] - c[0], b = c[2] - c[0];
    if (std::abs(a.x * b.y - a.y * b.x) < 1e-14) return "a triangle has no area in it";
  }
  return overlaps_itself(at) ? "it overlaps itself" : "";
}

LightFieldAtlas make_atlas(const FlatGeometry& geometry, const std::vector<AtlasPart>& parts,
                           const AtlasOptions& options) {
  LightFieldAtlas atlas;
  std::vector<Chart> charts;
  for (const AtlasPart& part : parts) {
    const std::string fault = check_second_uvs(geometry, part.item);
    if (!fault.empty()) atlas.own_charts.emplace_back(part.item, fault);
    for (const bool back : {false, true}) {
      if (back && !part.both_sides) continue;
      const auto triangles = chart_triangles(geometry, geometry.items[part.item], back);
      auto made = fault.empty() ? charts_of_uvs(geometry, triangles) : charts_of_cones(triangles);
      charts.insert(charts.end(), std::make_move_iterator(made.begin()), std::make_move_iterator(made.end()));
    }
  }
  if (charts.empty()) return atlas;
  const Packing packing = options.texels_per_m > 0.0 ? fit_density(charts, options.texels_per_m)
                                                     : fill_side(charts, std::clamp(options.side, 1, kLargestAtlas));
  atlas.side = packing.side;
  atlas.texels_per_m = packing.density;
  atlas.texel_of_cell.assign(static_cast<std::size_t>(atlas.side) * static_cast<std::size_t>(atlas.side),
                             LightFieldAtlas::kNone);
  ChartWriter writer(&atlas);
  for (std::size_t i = 0; i < charts.size(); ++i) writer.write(charts[i], packing.places[i]);
  return atlas;
}

void fill_masked_texels(const std::vector<bool>& masked, LightFieldAtlas* atlas) {
  // Cells spread outwards from texels that are not masked, over cells of the same chart that are.
  const int side = atlas->side;
  const auto chart_of = [&](std::uint32_t texel) { return atlas->sides[atlas->texels[texel].side].chart; };
  std::vector<std::uint32_t> now(atlas->texel_of_cell.size(), LightFieldAtlas::kNone);
  std::deque<std::size_t> front;
  for (std::size_t c = 0; c < now.size(); ++c) {
    const std::uint32_t t = atlas->texel_of_cell[c];
    if (t == LightFieldAtlas::kNone || masked[t]) continue;
    now[c] = t;
    front.push_back(c);
  }
  while (!front.empty()) {
    const std::size_t from = front.front();
    front.pop_front();
    const int x = static_cast<int>(from) % side, y = static_cast<int>(from) / side;
    for (const glm::ivec2& step : {glm::ivec2(1, 0), glm::ivec2(-1, 0), glm::ivec2(0, 1), glm::ivec2(0, -1)}) {
      const glm::ivec2 to(x + step.x, y + step.y);
      if (std::min(to.x, to.y) < 0 || std::max(to.x, to.y) >= side) continue;
      const auto c = static_cast<std::size_t>(to.y * side + to.x);
      const std::uint32_t there = atlas->texel_of_cell[c];
      if (there == LightFieldAtlas::kNone || now[c] != LightFieldAtlas::kNone || chart_of(there) != chart_of(now[from]))
        continue;
      now[c] = now[from];
      front.push_back(c);
    }
  }
  for (std::size_t c = 0; c < now.size(); ++c)
    if (now[c] != LightFieldAtlas::kNone) atlas->texel_of_cell[c] = now[c];
}

}  // namespace maquette
