
#include <array>
#include <limits>
#include <numbers>
#include <vector>

#include "render/materials/brdf_sampler.h"
#include "render/materials/brdf_tables.h"
#include "render/materials/symmetric_brdf.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr int kRowsPerBin = 3;
constexpr int kRowCount = kThetaHCount * kRowsPerBin;
constexpr int kColumnCount = 40;
/// Share of the probability that follows a Lambert lobe whatever the table contains, so that every valid direction has
/// a positive density.
constexpr double kFloorShare = 0.02;

/// One strip of theta_h of the construction grid, divided into kColumnCount equal pieces of [0, phi_max].
struct Row {
  double t_begin = 0.0, t_end = 0.0;
  double phi_max = 0.0;
  std::array<double, kColumnCount> mass = {};
  double total = 0.0;
};

struct ElevationGrid {
  std::vector<Row> rows;  ///< those that some view direction of the elevation's bin can use
  double total = 0.0;
};

double one_minus_cos(double theta) { return 2.0 * std::sin(0.5 * theta) * std::sin(0.5 * theta); }

/// Geometry of the rows: everything that can be above the horizon for any view direction of the bin, not for its centre
/// alone.
ElevationGrid make_rows(int elevation) {
  const double step = kHalfPi / kElevationCount;
  const double lowest = elevation * step, highest = (elevation + 1) * step;
  ElevationGrid grid;
  const double last_theta = std::min(largest_theta_h(highest), kHalfPi);
  for (int i = 0; i < kRowCount; ++i) {
    const double theta_begin = theta_h_of_bin_edge(static_cast<double>(i) / kRowsPerBin);
    if (theta_begin >= last_theta) break;
    const double theta_end = std::min(theta_h_of_bin_edge(static_cast<double>(i + 1) / kRowsPerBin), last_theta);
    Row row;
    row.t_begin = one_minus_cos(theta_begin);
    row.t_end = one_minus_cos(theta_end);
    for (double theta_h : {theta_begin, theta_end}) {
      for (double theta_o : {lowest, 0.5 * (lowest + highest), highest}) {
        row.phi_max = std::max(row.phi_max, largest_phi_h(theta_h, theta_o));
      }
    }
    // Between the tested corners the limit may be slightly larger.
    row.phi_max = std::min(std::numbers::pi, row.phi_max + 0.01);
    grid.rows.push_back(row);
  }
  return grid;
}

/// Adds Y(f) cos(theta_i) d omega_i over the row's cells for one view direction, and the same for f = 1 to
/// `floor_mass`.
void accumulate_view(const SymmetricBrdf& brdf, double theta_o, double weight, ElevationGrid& grid,
                     std::vector<std::array<double, kColumnCount>>& floor_mass) {
  const double sin_o = std::sin(theta_o), cos_o = std::cos(theta_o);
  for (std::size_t i = 0; i < grid.rows.size(); ++i) {
    Row& row = grid.rows[i];
    const double theta_h = theta_h_of_bin_edge((static_cast<double>(i) + 0.5) / kRowsPerBin);
    const double x = (static_cast<double>(i) + 0.5) / kRowsPerBin - 0.5;
    const double sin_h = std::sin(theta_h), cos_h = std::cos(theta_h);
    const double phi_step = row.phi_max / kColumnCount;
    const double solid_angle = (row.t_end - row.t_begin) * phi_step * weight;
    double sin_phi = std::sin(0.5 * phi_step), cos_phi = std::cos(0.5 * phi_step);
    const double sin_step = std::sin(phi_step), cos_step = std::cos(phi_step);
    for (std::size_t j = 0; j < kColumnCount; ++j) {
      const HalfVectorView view = view_of_half_vector(sin_h, cos_h, sin_phi, cos_phi, sin_o, cos_o);
      if (view.projection > 0.0 && view.cos_i > 0.0) {
        const double jacobian = 4.0 * view.projection * view.cos_i * solid_angle;
        const float value =
            SymmetricBrdf::interpolate(brdf.luminance, static_cast<float>(x), view.theta_d_bin, view.phi_d_rad);
        row.mass[j] += static_cast<double>(value) * jacobian;
        floor_mass[i][j] += jacobian;
      }
      const double next_sin = sin_phi * cos_step + cos_phi * sin_step;
      cos_phi = cos_phi * cos_step - sin_phi * sin_step;
      sin_phi = next_sin;
    }
  }
}

ElevationGrid make_grid(const SymmetricBrdf& brdf, int elevation) {
  ElevationGrid grid = make_rows(elevation);
  std::vector<std::array<double, kColumnCount>> floor_mass(grid.rows.size());
  for (double offset : {0.25, 0.75}) {
    accumulate_view(brdf, (elevation + offset) * kHalfPi / kElevationCount, 0.5, grid, floor_mass);
  }
  double total = 0.0, floor_total = 0.0, area = 0.0;
  for (std::size_t i = 0; i < grid.rows.size(); ++i) {
    for (std::size_t j = 0; j < kColumnCount; ++j) {
      total += grid.rows[i].mass[j];
      floor_total += floor_mass[i][j];
    }
    area += (grid.rows[i].t_end - grid.rows[i].t_begin) * grid.rows[i].phi_max;
  }
  // A black table is sampled like Lambert. A tenth of the floor is uniform, so that cells at the horizon stay positive
  // too.
  const double share = total > 0.0 ? kFloorShare : 1.0;
  const double scale = total > 0.0 ? (1.0 - share) / total : 0.0;
  for (std::size_t i = 0; i < grid.rows.size(); ++i) {
    Row& row = grid.rows[i];
    const double uniform = 0.1 * share * (row.t_end - row.t_begin) * row.phi_max / (kColumnCount * area);
    for (std::size_t j = 0; j < kColumnCount; ++j) {
      row.mass[j] = row.mass[j] * scale + 0.9 * share * floor_mass[i][j] / floor_total + uniform;
      row.total += row.mass[j];
    }
    grid.total += row.total;
  }
  return grid;
}

/// A possible end of a theta cell: cumulative mass and integral of the squared density up to t.
struct Candidate {
  double t = 0.0, mass = 0.0, squared = 0.0;
};

/// The edges of all rows, and points of equal mass between them, four to a cell.
std::vector<Candidate> edge_candidates(const ElevationGrid& grid,
                                       const std::array<double, kThetaCellCount + 1>& quantiles) {
  std::vector<double> wanted;
  for (std::size_t k = 0; k < kThetaCellCount; ++k) {
    for (int part = 0; part < 4; ++part)
      wanted.push_back(quantiles[k] + (quantiles[k + 1] - quantiles[k]) * 0.25 * part);
  }
  std::vector<Candidate> candidates = {Candidate{}};
  std::size_t next = 1;
  Candidate at;
  for (const Row& row : grid.rows) {
    const double mass = row.total / grid.total, width = row.t_end - row.t_begin;
    const auto add = [&](double inside) {
      const Candidate c{row.t_begin + inside * width, at.mass + inside * mass,
                        at.squared + inside * mass * mass / width};
      if (c.t > candidates.back().t + 1e-4 * width) candidates.push_back(c);
    };
    while (next < wanted.size() && wanted[next] < at.mass + mass) add((wanted[next++] - at.mass) / mass);
    add(1.0);
    at = {row.t_end, at.mass + mass, at.squared + mass * mass / width};
  }
  candidates.back() = at;
  return candidates;
}

/// Ends of the theta cells, chosen near the quantiles so that the second moment of target over density, the sum over
/// cells of width * integral(density^2) / mass, is minimal. With quantiles alone one cell could contain both the foot
/// of a sharp lobe and a stretch of the diffuse base, and would sample the foot a hundred times too rarely. Dynamic
/// programming over the candidates.
std::vector<double> partition_theta(const ElevationGrid& grid, shared::BrdfSampler sampler) {
  std::array<double, kThetaCellCount + 1> quantiles = {};
  std::array<double, kThetaCellCount> cell_mass = {};
  for (std::size_t k = 0; k < kThetaCellCount; ++k) {
    cell_mass[k] = static_cast<double>(sampler.theta_cell_mass(static_cast<int>(k)));
    quantiles[k + 1] = quantiles[k] + cell_mass[k];
  }
  const std::vector<Candidate> candidates = edge_candidates(grid, quantiles);
  const std::size_t last = candidates.size() - 1;
  struct Layer {  // reachable ends of one cell
    std::size_t first = 0;
    std::vector<double> cost;
    std::vector<std::size_t> parent;
  };
  std::vector<Layer> layers(kThetaCellCount + 1);
  layers[0] = {0, {0.0}, {0}};
  for (std::size_t k = 0; k < kThetaCellCount; ++k) {
    const double reach = 1.5 * std::max(cell_mass[k], cell_mass[std::min<std::size_t>(k + 1, kThetaCellCount - 1)]);
    const auto by_mass = [](const Candidate& c, double mass) { return c.mass < mass; };
    const auto find = [&](double mass) {
      return static_cast<std::size_t>(std::lower_bound(candidates.begin(), candidates.end(), mass, by_mass) -
                                      candidates.begin());
    };
    // Leaves enough candidates on both sides for the remaining cells.
    const std::size_t remaining = kThetaCellCount - 1 - k;
    std::size_t begin = std::max(find(quantiles[k + 1] - reach), k + 1);
    std::size_t end = std::min(find(quantiles[k + 1] + reach), last - remaining);
    begin = std::min(std::max(begin, layers[k].first + 1), last - remaining);
    end = std::max(begin, end);
    if (remaining == 0) begin = end = last;
    Layer& layer = layers[k + 1];
    layer.first = begin;
    layer.cost.assign(end - begin + 1, std::numeric_limits<double>::infinity());
    layer.parent.assign(end - begin + 1, layers[k].first);
    for (std::size_t i = 0; i < layers[k].cost.size(); ++i) {
      const std::size_t from = layers[k].first + i;
      for (std::size_t to = std::max(begin, from + 1); to <= end; ++to) {
        const double cost = layers[k].cost[i] + (candidates[to].t - candidates[from].t) *
                                                    (candidates[to].squared - candidates[from].squared) / cell_mass[k];
        if (cost < layer.cost[to - begin]) {
          layer.cost[to - begin] = cost;
          layer.parent[to - begin] = from;
        }
      }
    }
  }
  std::vector<double> edges(kThetaCellCount + 1);
  std::size_t at = last;
  for (std::size_t k = kThetaCellCount; k > 0; --k) {
    edges[k] = candidates[at].t;
    at = layers[k].parent[at - layers[k].first];
  }
  return edges;
}

/// Equal-mass cells of phi for the strip [t_begin, t_end].
void partition_phi(const ElevationGrid& grid, double t_begin, double t_end, std::size_t first_row, glm::vec2* cells) {
  constexpr int kFine = 2 * kColumnCount;
  std::array<double, kFine> mass = {};
  double phi_max = 0.0;
  std::size_t last_row = first_row;
  for (std::size_t i = first_row; i < grid.rows.size() && grid.rows[i].t_begin < t_end; ++i) {
    phi_max = std::max(phi_max, grid.rows[i].phi_max);
    last_row = i;
  }
  const double fine_step = phi_max / kFine;
  for (std::size_t i = first_row; i <= last_row; ++i) {
    const Row& row = grid.rows[i];
    const double overlap = std::max(0.0, std::min(t_end, row.t_end) - std::max(t_begin, row.t_begin));
    const double share = overlap / (row.t_end - row.t_begin);
    const double step = row.phi_max / kColumnCount;
    for (int f = 0; f < kFine; ++f) {  // mass of the row's step function over the fine piece
      const double a = f * fine_step, b = std::min((f + 1) * fine_step, row.phi_max);
      for (int j = static_cast<int>(a / step); j < kColumnCount && j * step < b; ++j) {
        const double length = std::min(b, (j + 1) * step) - std::max(a, j * step);
        if (length > 0.0)
          mass[static_cast<std::size_t>(f)] += share * row.mass[static_cast<std::size_t>(j)] * length / step;
      }
    }
  }
  double total = 0.0;
  for (double m : mass) total += m;
  double begin = 0.0, before = 0.0;
  std::size_t f = 0;
  for (int p = 0; p < kPhiCellCount; ++p) {
    const double wanted = total * (p + 1) / kPhiCellCount;
    while (f + 1 < kFine && before + mass[f] < wanted) before += mass[f++];
    const double inside = mass[f] > 0.0 ? std::clamp((wanted - before) / mass[f], 0.0, 1.0) : 1.0;
    const double end = p + 1 == kPhiCellCount ? phi_max : (static_cast<double>(f) + inside) * fine_step;
    cells[p] = glm::vec2(static_cast<float>(begin), static_cast<float>(end));
    begin = end;
  }
}

}  // namespace

void compute_importance(const SymmetricBrdf& brdf, BrdfTables& tables) {
  tables.theta_cells.resize(std::size_t{kElevationCount} * kThetaCellCount);
  tables.phi_cells.resize(tables.theta_cells.size() * kPhiCellCount);
  parallel_for(0, kElevationCount, [&](int elevation) {
    const ElevationGrid grid = make_grid(brdf, elevation);
    const std::vector<double> edges = partition_theta(grid, shared::BrdfSampler(tables));
    std::size_t row = 0;
    for (std::size_t k = 0; k < kThetaCellCount; ++k) {
      const std::size_t cell = static_cast<std::size_t>(elevation) * kThetaCellCount + k;
      tables.theta_cells[cell] = glm::vec2(static_cast<float>(edges[k]), static_cast<float>(edges[k + 1]));
      while (row + 1 < grid.rows.size() && grid.rows[row].t_end <= edges[k]) ++row;
      partition_phi(grid, edges[k], edges[k + 1], row, &tables.phi_cells[cell * kPhiCellCount]);
    }
  });
}

}  // namespace maquette
