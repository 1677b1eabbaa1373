#include "render/lights/light_grid.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace maquette {

namespace {

/// Inner cells at most, about a hand wide in a car.
constexpr double kCells = 8192.0;
/// They reach this share of the lights' extent beyond them: what a light is near to must not be in the layer around.
constexpr double kBeyond = 0.1;
/// Share of the choice that is by power wherever the point is.
constexpr double kByPower = 0.25;

struct Box {
  glm::dvec3 low{1e300}, high{-1e300};
  void add(const glm::dvec3& p) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  double diagonal() const { return low.x <= high.x ? glm::length(high - low) : 0.0; }
};

Box box_of(const LightRecord& light) {
  Box box;
  const glm::dvec3 a(light.position);
  box.add(a);
  if (light.kind == shared::kLightTriangle) {
    box.add(a + glm::dvec3(light.direction));
    box.add(a + glm::dvec3(light.edge2));
  }
  return box;
}

/// Lights that are drawn as one, and what they are seen as from afar.
struct Cluster {
  std::vector<int> lights;
  Box box;
  double power = 0.0;  ///< share of all
  bool distant = false;
};

Cluster make_cluster(const std::vector<LightRecord>& lights, std::vector<int> members, bool distant) {
  Cluster cluster;
  cluster.lights = std::move(members);
  cluster.distant = distant;
  for (const int i : cluster.lights) {
    const LightRecord& light = lights[static_cast<std::size_t>(i)];
    cluster.power += static_cast<double>(light.selection_pdf);
    if (distant) continue;
    const Box box = box_of(light);
    cluster.box.add(box.low);
    cluster.box.add(box.high);
  }
  return cluster;
}

/// At the middle light along the longest axis.
void split(const std::vector<LightRecord>& lights, std::vector<Cluster>* clusters, std::size_t which) {
  std::vector<int> members = std::move((*clusters)[which].lights);
  const glm::dvec3 size = (*clusters)[which].box.high - (*clusters)[which].box.low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto middle_of = [&](int i) {
    const Box box = box_of(lights[static_cast<std::size_t>(i)]);
    return box.low[axis] + box.high[axis];
  };
  std::stable_sort(members.begin(), members.end(), [&](int a, int b) { return middle_of(a) < middle_of(b); });
  const auto half = members.begin() + static_cast<std::ptrdiff_t>(members.size() / 2);
  const Cluster upper = make_cluster(lights, {half, members.end()}, false);
  (*clusters)[which] = make_cluster(lights, {members.begin(), half}, false);
  clusters->push_back(upper);
}

std::vector<Cluster> make_clusters(const std::vector<LightRecord>& lights) {
  std::vector<int> near, distant;
  for (std::size_t i = 0; i < lights.size(); ++i)
    (lights[i].kind == shared::kLightDirectional ? distant : near).push_back(static_cast<int>(i));
  std::vector<Cluster> clusters;
  if (!distant.empty()) clusters.push_back(make_cluster(lights, std::move(distant), true));
  if (near.empty()) return clusters;
  clusters.push_back(make_cluster(lights, std::move(near), false));
  while (clusters.size() < LightGrid::kMaxClusters) {
    // The most extended one: where a cluster is small beside its distance, power says enough.
    std::size_t which = clusters.size();
    double longest = -1.0;
    for (std::size_t k = 0; k < clusters.size(); ++k) {
      if (clusters[k].distant || clusters[k].lights.size() < 2 || clusters[k].box.diagonal() <= longest) continue;
      longest = clusters[k].box.diagonal();
      which = k;
    }
    if (which == clusters.size()) break;
    split(lights, &clusters, which);
  }
  return clusters;
}

void place_cells(const Box& lights, LightGrid* grid) {
  const glm::dvec3 beyond(kBeyond * lights.diagonal());
  const Box box{lights.low - beyond, lights.high + beyond};
  const glm::dvec3 size = glm::max(box.high - box.low, glm::dvec3(1e-30));
  const double side = std::cbrt(size.x * size.y * size.z / kCells);
  for (int axis = 0; axis < 3; ++axis) {
    const double count = std::clamp(std::floor(size[axis] / std::max(side, 1e-30)), 1.0, 256.0);
    grid->low[axis] = static_cast<float>(box.low[axis]);
    grid->cell_size[axis] = static_cast<float>(size[axis] / count);
    grid->cells[axis] = static_cast<int>(count) + 2;
  }
}

/// The layer around is as thick as the box is long: what lies further out is far from all lights alike.
Box box_of_cell(const LightGrid& grid, const glm::ivec3& cell, double layer_m) {
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = grid.low[axis], size = grid.cell_size[axis];
    const int last = grid.cells[axis] - 1;
    box.low[axis] = cell[axis] == 0 ? low - layer_m : low + (cell[axis] - 1) * size;
    box.high[axis] = cell[axis] == last ? low + (last - 1) * size + layer_m : low + cell[axis] * size;
  }
  return box;
}

/// Light that a cluster may bring to a cell: its power over the square of the distance between both boxes, and no
/// nearer than their own sizes.
double importance(const Cluster& cluster, const Box& cell, double scene_diagonal) {
  const double distant = 0.25 * scene_diagonal * scene_diagonal;  // power is that of a disc so large
  if (cluster.distant) return cluster.power / std::max(distant, 1e-300);
  const glm::dvec3 apart =
      glm::max(glm::max(cluster.box.low - cell.high, cell.low - cluster.box.high), glm::dvec3(0.0));
  const double own = 0.25 * (cell.diagonal() + cluster.box.diagonal());
  return cluster.power / std::max(glm::dot(apart, apart) + own * own, 1e-300);
}

}  // namespace

LightGrid build_light_grid(const LightList& list) {
  LightGrid grid;
  const std::vector<Cluster> clusters = make_clusters(list.lights);
  Box box;
  for (const Cluster& cluster : clusters) {
    grid.first.push_back(static_cast<int>(grid.lights.size()));
    std::vector<double> powers;
    for (const int i : cluster.lights) {
      grid.order.push_back(i);
      grid.lights.push_back(list.lights[static_cast<std::size_t>(i)]);
      powers.push_back(static_cast<double>(grid.lights.back().selection_pdf));
    }
    const std::vector<float> cdf = cumulative_in_steps(powers);
    for (std::size_t i = 0; i < cdf.size(); ++i) {
      LightRecord& light = grid.lights[static_cast<std::size_t>(grid.first.back()) + i];
      light.selection_pdf = cdf[i] - (i > 0 ? cdf[i - 1] : 0.0f);
      light.cdf = cdf[i];
    }
    if (cluster.distant) continue;
    box.add(cluster.box.low);
    box.add(cluster.box.high);
  }
  grid.first.push_back(static_cast<int>(grid.lights.size()));
  grid.stride = (std::max(grid.clusters(), 1) + 3) / 4 * 4;
  const bool one_row = clusters.size() < 2 || !(box.diagonal() > 0.0);
  if (!one_row) place_cells(box, &grid);
  const double diagonal = box.diagonal();
  for (int z = 0; z < grid.cells.z; ++z)
    for (int y = 0; y < grid.cells.y; ++y)
      for (int x = 0; x < grid.cells.x; ++x) {
        const Box cell = one_row ? Box{} : box_of_cell(grid, {x, y, z}, diagonal);
        std::vector<double> near, weights;
        double sum = 0.0;
        for (const Cluster& cluster : clusters) {
          near.push_back(one_row ? cluster.power : importance(cluster, cell, list.diagonal_m));
          sum += near.back();
        }
        for (std::size_t k = 0; k < clusters.size(); ++k)
          weights.push_back(kByPower * clusters[k].power + (1.0 - kByPower) * near[k] / std::max(sum, 1e-300));
        std::vector<float> cdf = cumulative_in_steps(weights);
        cdf.resize(static_cast<std::size_t>(grid.stride), 1.0f);
        grid.cumulative.insert(grid.cumulative.end(), cdf.begin(), cdf.end());
      }
  return grid;
}

double light_probability(const LightGrid& grid, const glm::ivec3& cell, int index) {
  const int row = (cell.z * grid.cells.y + cell.y) * grid.cells.x + cell.x;
  const auto k =
      static_cast<std::size_t>(std::upper_bound(grid.first.begin(), grid.first.end(), index) - grid.first.begin() - 1);
  const std::size_t at = static_cast<std::size_t>(row * grid.stride) + k;
  const double before = k > 0 ? static_cast<double>(grid.cumulative[at - 1]) : 0.0;
  return (static_cast<double>(grid.cumulative[at]) - before) *
         static_cast<double>(grid.lights[static_cast<std::size_t>(index)].selection_pdf);
}

}  // namespace maquette
