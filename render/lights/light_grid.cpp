#include "render/lights/light_grid.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/math/wide.h"
#include "scenes/luminance.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

/// Most inner cells; one is about a hand wide in a car.
constexpr double kCells = 4096.0;
/// The inner cells extend beyond the lights by this share of the lights' extent: points close to a light must not fall
/// into the outer layer.
constexpr double kBeyond = 0.1;
/// Share of the probability that is proportional to power, at every point.
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

/// Unit normal of a one-sided triangle; 0 for lights that emit in all directions.
glm::dvec3 normal_of(const LightRecord& light) {
  if (light.kind != shared::kLightTriangle || light.range_m > 0.0f) return glm::dvec3(0.0);
  // The product of two edges of 1e-20 m underflows in floats, not in doubles.
  const glm::dvec3 n = glm::cross(glm::dvec3(light.direction), glm::dvec3(light.edge2));
  const double length = glm::length(n);
  return length > 0.0 ? n / length : glm::dvec3(0.0);
}

/// A node of the tree.
struct TreeNode {
  LightNode range;
  std::array<int, 2> children{-1, -1};
  Box box;
  double power = 0.0;  ///< share of the total
  bool distant = false;
};

using Members = std::vector<int>::iterator;

/// Nodes of a tree over a list's lights, and the lights in the order of its leaves.
struct Tree {
  std::vector<int> order;
  std::vector<TreeNode> nodes;
  std::vector<int> roots;
};

/// Adds the node of order[first, last), split at the middle light along the longest axis.
int add_node(const std::vector<LightRecord>& lights, std::size_t first, std::size_t last, bool distant, Tree* tree) {
  const auto begin = tree->order.begin() + static_cast<std::ptrdiff_t>(first);
  const auto end = tree->order.begin() + static_cast<std::ptrdiff_t>(last);
  TreeNode node;
  node.range.first = static_cast<int>(first);
  node.range.count = static_cast<int>(last - first);
  node.distant = distant;
  for (Members i = begin; i != end; ++i) {
    const LightRecord& light = lights[static_cast<std::size_t>(*i)];
    node.power += static_cast<double>(light.selection_pdf);
    if (distant) continue;
    const Box box = box_of(light);
    node.box.add(box.low);
    node.box.add(box.high);
  }
  const int id = static_cast<int>(tree->nodes.size());
  tree->nodes.push_back(node);
  if (distant || last - first < 2) return id;
  const glm::dvec3 size = node.box.high - node.box.low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto middle_of = [&](int i) {
    const Box box = box_of(lights[static_cast<std::size_t>(i)]);
    return box.low[axis] + box.high[axis];
  };
  std::stable_sort(begin, end, [&](int a, int b) { return middle_of(a) < middle_of(b); });
  const std::size_t middle = first + (last - first) / 2;
  const int lower = add_node(lights, first, middle, false, tree), upper = add_node(lights, middle, last, false, tree);
  tree->nodes[static_cast<std::size_t>(id)].children = {lower, upper};
  return id;
}

/// Groups of lights: distant ones, those that emit in all directions, and one-sided triangles by the dominant axis of
/// their normals. A point behind the lights of a node is then behind most of them.
std::size_t group_of(const LightRecord& light) {
  if (light.kind == shared::kLightDirectional) return 0;
  const glm::dvec3 n = normal_of(light), size = glm::abs(n);
  if (n == glm::dvec3(0.0)) return 1;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  return 2 + 2 * static_cast<std::size_t>(axis) + (n[axis] > 0.0 ? 1 : 0);
}

Tree make_tree(const std::vector<LightRecord>& lights) {
  std::array<std::vector<int>, 8> groups;
  for (std::size_t i = 0; i < lights.size(); ++i) groups[group_of(lights[i])].push_back(static_cast<int>(i));
  Tree tree;
  for (const std::vector<int>& group : groups) tree.order.insert(tree.order.end(), group.begin(), group.end());
  std::size_t first = 0;
  for (std::size_t k = 0; k < groups.size(); ++k) {
    if (groups[k].empty()) continue;
    tree.roots.push_back(add_node(lights, first, first + groups[k].size(), k == 0, &tree));
    first += groups[k].size();
  }
  return tree;
}

void lay_out_cells(const Box& lights, LightGrid* grid) {
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

/// The outer layer is as thick as the box is long: all points further out are about equally far from all lights.
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

struct Ball {
  glm::dvec3 centre{0.0};
  double radius = 0.0;
};

/// The ball around a box; a point where there is none.
Ball ball_of(const Box& box) {
  if (!(box.low.x <= box.high.x)) return {};
  return {0.5 * (box.low + box.high), 0.5 * box.diagonal()};
}

/// Upper bounds of the illuminance (lux) that lights may cause in a ball: intensity times the largest cosine at the
/// light towards the ball, over the squared distance (at least the ball's radius). 0 where all of the ball is behind
/// the light. As arrays of floats for SIMD lanes: lengths in units of the lights' extent, intensities relative to the
/// largest.
struct Emitters {
  glm::dvec3 origin{0.0};
  double unit_m = 1.0, strongest = 0.0;  ///< m; cd
  std::vector<float> x, y, z, radius, normal_x, normal_y, normal_z;
  std::vector<float> everywhere;  ///< least cosine: 1 for emission in all directions, else 0
  std::vector<float> intensity;   ///< along the normal; 0 of distant lights
  std::vector<double> distant_lux, inverse_power;
  std::vector<char> triangle;
};

Emitters emitters_of(const std::vector<LightRecord>& lights, const std::vector<double>& powers, const Box& box) {
  Emitters e;
  if (box.diagonal() > 0.0) e.unit_m = box.diagonal();
  if (box.low.x <= box.high.x) e.origin = 0.5 * (box.low + box.high);
  std::vector<double> candelas;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const LightRecord& light = lights[i];
    const bool distant = light.kind == shared::kLightDirectional, triangle = light.kind == shared::kLightTriangle;
    double strength = luminance(glm::dvec3(light.color));
    if (triangle) strength *= 0.5 * glm::length(glm::cross(glm::dvec3(light.direction), glm::dvec3(light.edge2)));
    const Box own = distant ? Box{e.origin, e.origin} : box_of(light);
    const glm::vec3 centre((0.5 * (own.low + own.high) - e.origin) / e.unit_m), normal(normal_of(light));
    e.x.push_back(centre.x);
    e.y.push_back(centre.y);
    e.z.push_back(centre.z);
    e.radius.push_back(static_cast<float>(0.5 * own.diagonal() / e.unit_m));
    e.normal_x.push_back(normal.x);
    e.normal_y.push_back(normal.y);
    e.normal_z.push_back(normal.z);
    e.everywhere.push_back(normal == glm::vec3(0.0f) ? 1.0f : 0.0f);
    e.distant_lux.push_back(distant ? strength : 0.0);
    e.inverse_power.push_back(1.0 / powers[i]);
    e.triangle.push_back(triangle ? 1 : 0);
    candelas.push_back(distant ? 0.0 : strength);
    e.strongest = std::max(e.strongest, candelas.back());
  }
  // The weakest light stays above 0 after division by a square.
  for (const double cd : candelas)
    e.intensity.push_back(cd > 0.0 ? static_cast<float>(std::max(cd / e.strongest, 1e-24)) : 0.0f);
  return e;
}

/// Illuminance of each light in units of strongest / unit_m^2; 0 for distant lights.
MAQUETTE_WIDE void compute_relative_lux(const Emitters& e, const Ball& ball, float* __restrict relative) {
  const glm::vec3 at((ball.centre - e.origin) / e.unit_m);
  const auto size = static_cast<float>(ball.radius / e.unit_m);
  const float *x = e.x.data(), *y = e.y.data(), *z = e.z.data(), *radius = e.radius.data();
  const float *nx = e.normal_x.data(), *ny = e.normal_y.data(), *nz = e.normal_z.data();
  const float *everywhere = e.everywhere.data(), *intensity = e.intensity.data();
  const std::size_t count = e.x.size();
#pragma omp simd
  for (std::size_t k = 0; k < count; ++k) {
    const float dx = at.x - x[k], dy = at.y - y[k], dz = at.z - z[k], radii = size + radius[k];
    const float sum = dx * dx + dy * dy + dz * dz + radii * radii;
    const float square = sum > 0.0f ? sum : 1.0f;  // all lights at one point
    // Rounding must not make a light vanish that is seen at a grazing angle.
    const float height = nx[k] * dx + ny[k] * dy + nz[k] * dz + radii * 1.00001f;
    const float near = 1.0f / std::sqrt(square);
    const float least = everywhere[k], cosine = std::max(std::min(height * near, 1.0f), least);
    relative[k] = intensity[k] * cosine * (near * near);
  }
}

/// A node of a cell's cut.
struct Entry {
  int node = 0;
  double importance = 0.0;  ///< root mean square of what one of its lights, chosen by power, may cause
  double spread = 0.0;      ///< variance of the same
  double power = 0.0;       ///< of all its lights; 0 where none reaches the cell
};

/// Running sums over the lights of a tree.
struct CellSums {
  std::vector<double> lux, second;  ///< of the illuminances, and of their squares over power
  std::vector<int> shining;         ///< how many lights reach the cell: a small value beside a sun is not 0
  void resize(std::size_t size) {
    lux.resize(size);
    second.resize(size);
    shining.resize(size);
  }
  Entry entry(const Tree& tree, int id) const {
    const TreeNode& node = tree.nodes[static_cast<std::size_t>(id)];
    const auto first = static_cast<std::size_t>(node.range.first),
               last = first + static_cast<std::size_t>(node.range.count);
    Entry e;
    e.node = id;
    const double mean = lux[last] - lux[first], square = node.power * (second[last] - second[first]);
    e.importance = std::sqrt(std::max(square, 0.0));
    e.power = shining[last] > shining[first] ? node.power : 0.0;
    if (node.children[0] >= 0 && square - mean * mean > 1e-9 * square) e.spread = square - mean * mean;
    return e;
  }
};

/// Splits the nodes with the largest variance until there are `most`.
std::vector<Entry> cut_for(const Tree& tree, const CellSums& sums, std::size_t most) {
  std::vector<Entry> heap, done;
  const auto less = [](const Entry& a, const Entry& b) { return a.spread < b.spread; };
  const auto add = [&](int id) {
    const Entry entry = sums.entry(tree, id);
    if (!(entry.spread > 0.0)) {
      done.push_back(entry);
      return;
    }
    heap.push_back(entry);
    std::push_heap(heap.begin(), heap.end(), less);
  };
  for (const int root : tree.roots) add(root);
  while (!heap.empty() && heap.size() + done.size() < most) {
    std::pop_heap(heap.begin(), heap.end(), less);
    const std::array<int, 2> children = tree.nodes[static_cast<std::size_t>(heap.back().node)].children;
    heap.pop_back();
    for (const int child : children) add(child);
  }
  done.insert(done.end(), heap.begin(), heap.end());
  std::sort(done.begin(), done.end(), [](const Entry& a, const Entry& b) { return a.node < b.node; });
  return done;
}

/// Probabilities of a cut's nodes. The part by power counts only nodes with a light that reaches the cell.
std::vector<double> weights_of(const Tree& tree, const std::vector<Entry>& cut) {
  double sum = 0.0, power = 0.0;
  for (const Entry& entry : cut) {
    sum += entry.importance;
    power += entry.power;
  }
  std::vector<double> weights;
  for (const Entry& entry : cut) {
    const double by_power = power > 0.0 ? entry.power / power : tree.nodes[static_cast<std::size_t>(entry.node)].power;
    weights.push_back(sum > 0.0 ? kByPower * by_power + (1.0 - kByPower) * entry.importance / sum : by_power);
  }
  return weights;
}

/// Fills row `i` of a grid whose cells are laid out.
void fill_cell(const Tree& tree, const Emitters& emitters, const Box& lights, std::size_t i, LightGrid* grid) {
  // An outer cell extends to a thousand times the lights' extent: points farther out see the lights as from there.
  constexpr double kOuterExtent = 1000.0, kNear = 0.1;
  const auto columns = static_cast<std::size_t>(grid->cells.x), rows = static_cast<std::size_t>(grid->cells.y);
  const auto stride = static_cast<std::size_t>(grid->stride);
  const glm::ivec3 at(i % columns, i / columns % rows, i / (columns * rows));
  const double extent = lights.diagonal();
  const Box cell = extent > 0.0 ? box_of_cell(*grid, at, kOuterExtent * extent) : lights;
  const Ball all = ball_of(cell);
  // In outer cells the part near the lights counts as well; lights that the near part never sees from the front are
  // judged by the whole cell.
  const bool outside =
      extent > 0.0 && (glm::any(glm::equal(at, glm::ivec3(0))) || glm::any(glm::equal(at, grid->cells - 1)));
  const Ball near{glm::clamp(0.5 * (lights.low + lights.high), cell.low, cell.high), kNear * extent};
  const std::size_t count = emitters.intensity.size();
  thread_local CellSums sums;
  thread_local std::vector<float> to_all, to_near;
  sums.resize(count + 1);
  to_all.resize(count);
  to_near.assign(count, 0.0f);
  compute_relative_lux(emitters, all, to_all.data());
  if (outside) compute_relative_lux(emitters, near, to_near.data());
  const double unit = emitters.strongest / (emitters.unit_m * emitters.unit_m);
  double of_triangles = 0.0;
  for (std::size_t k = 0; k < count; ++k) {
    const double lux = (static_cast<double>(to_all[k]) + static_cast<double>(to_near[k])) * unit +
                       (outside ? 2.0 : 1.0) * emitters.distant_lux[k];
    sums.lux[k + 1] = sums.lux[k] + lux;
    of_triangles += emitters.triangle[k] != 0 ? lux : 0.0;
    sums.second[k + 1] = sums.second[k] + lux * lux * emitters.inverse_power[k];
    sums.shining[k + 1] = sums.shining[k] + (lux > 0.0 ? 1 : 0);
  }
  const std::size_t most = std::min<std::size_t>(LightGrid::kMaxNodes, count);
  const std::vector<Entry> cut = cut_for(tree, sums, most);
  const std::vector<float> row = cumulative_in_steps(weights_of(tree, cut));
  for (std::size_t k = 0; k < stride; ++k) {
    grid->cut[i * stride + k] = static_cast<std::uint32_t>(cut[std::min(k, cut.size() - 1)].node);
    if (k < row.size()) grid->cumulative[i * stride + k] = row[k];
  }
  grid->lux[i] = static_cast<float>(std::min(sums.lux.back(), 1e30));
  grid->lux_of_triangles[i] = static_cast<float>(std::min(of_triangles, 1e30));
}

}  // namespace

LightGrid build_light_grid(const LightList& list) {
  LightGrid grid;
  const Tree tree = make_tree(list.lights);
  grid.order = tree.order;
  std::vector<double> powers;
  for (const int i : tree.order) {
    grid.lights.push_back(list.lights[static_cast<std::size_t>(i)]);
    powers.push_back(static_cast<double>(grid.lights.back().selection_pdf));
  }
  const std::vector<float> cdf = cumulative_in_steps(powers);
  for (std::size_t i = 0; i < cdf.size(); ++i) {
    grid.lights[i].selection_pdf = cdf[i] - (i > 0 ? cdf[i - 1] : 0.0f);
    grid.lights[i].cdf = cdf[i];
    grid.running_power.push_back(cdf[i]);
  }
  Box box;
  for (const TreeNode& node : tree.nodes) {
    LightNode range = node.range;
    const auto first = static_cast<std::size_t>(range.first);
    range.before = first > 0 ? cdf[first - 1] : 0.0f;
    range.share = cdf[first + static_cast<std::size_t>(range.count) - 1] - range.before;
    grid.nodes.push_back(range);
    if (node.distant) continue;
    box.add(node.box.low);
    box.add(node.box.high);
  }
  const double extent = box.diagonal();
  if (extent > 0.0) lay_out_cells(box, &grid);
  const std::size_t most = std::min<std::size_t>(LightGrid::kMaxNodes, std::max<std::size_t>(grid.lights.size(), 1));
  grid.stride = static_cast<int>((most + 3) / 4 * 4);
  const auto stride = static_cast<std::size_t>(grid.stride);
  const auto columns = static_cast<std::size_t>(grid.cells.x), rows = static_cast<std::size_t>(grid.cells.y);
  const std::size_t count = columns * rows * static_cast<std::size_t>(grid.cells.z);
  grid.cumulative.assign(count * stride, 1.0f);
  grid.cut.assign(count * stride, 0u);
  if (tree.roots.empty()) return grid;
  grid.lux.assign(count, 0.0f);
  grid.lux_of_triangles.assign(count, 0.0f);
  const Emitters emitters = emitters_of(grid.lights, powers, box);
  parallel_for(std::size_t{0}, count, [&](std::size_t i) { fill_cell(tree, emitters, box, i, &grid); });
  return grid;
}

std::size_t light_cell(const LightGrid& grid, const glm::vec3& position) {
  int cell = 0;
  for (int axis = 2; axis >= 0; --axis) {
    const float coordinate = std::floor((position[axis] - grid.low[axis]) / grid.cell_size[axis]) + 1.0f;
    const int last = grid.cells[axis] - 1;
    // In this order, so that NaN gets a cell as well.
    const int at = coordinate > 0.0f ? coordinate < static_cast<float>(last) ? static_cast<int>(coordinate) : last : 0;
    cell = cell * grid.cells[axis] + at;
  }
  return static_cast<std::size_t>(cell);
}

LightPick choose_light(const LightGrid& grid, std::size_t cell, float u, std::uint32_t within) {
  const std::size_t row = cell * static_cast<std::size_t>(grid.stride);
  u = std::min(u, 0x1.fffffep-1f);  // float sums may round up to 1, where the entries beyond the cut's end are
  const auto sums = grid.cumulative.begin() + static_cast<std::ptrdiff_t>(row);
  const auto k = static_cast<std::size_t>(std::upper_bound(sums, sums + (grid.stride - 1), u) - sums);
  const float share = grid.cumulative[row + k] - (k > 0 ? grid.cumulative[row + k - 1] : 0.0f);
  const LightNode& node = grid.nodes[grid.cut[row + k]];
  const auto steps = static_cast<std::uint64_t>(node.share * 0x1p24f);
  const float power = node.before + static_cast<float>((within * steps) >> 32) * 0x1p-24f;
  const auto first = grid.running_power.begin() + node.first;
  const auto index =
      static_cast<std::size_t>(std::upper_bound(first, first + (node.count - 1), power) - grid.running_power.begin());
  // Does not read the light itself, which is elsewhere in memory.
  const float own = grid.running_power[index] - (index > 0 ? grid.running_power[index - 1] : 0.0f);
  return {index, share * (own / node.share)};
}

float light_probability(const LightGrid& grid, std::size_t cell, std::size_t index) {
  const std::size_t row = cell * static_cast<std::size_t>(grid.stride);
  // A cut's nodes have the order of the lights.
  const auto cut = grid.cut.begin() + static_cast<std::ptrdiff_t>(row);
  const auto node = std::partition_point(cut, cut + (grid.stride - 1), [&](std::uint32_t id) {
    return grid.nodes[id].first + grid.nodes[id].count <= static_cast<int>(index);
  });
  const auto k = row + static_cast<std::size_t>(node - cut);
  const float share = grid.cumulative[k] - (k > row ? grid.cumulative[k - 1] : 0.0f);
  return share * (grid.lights[index].selection_pdf / grid.nodes[*node].share);
}

}  // namespace maquette
