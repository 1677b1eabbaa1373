// Cell BRDFs of a whole octree: selects the nodes that have one, fits the compression to a sample of them, and encodes
// the rest while baking.
#include "render/octree/cell_brdf_bake.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <random>
#include <span>

#include "render/octree/cell_rays.h"
#include "render/octree/octree_shared.h"
#include "scenes/files.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

/// Number of vectors that are compressed together.
constexpr std::size_t kBatchSize = 16;
/// A material below this share of a cell's area is ignored.
constexpr double kSecondMaterial = 0.02;
/// Rays start this far above their surface, in finest cells: the float precision of positions in the largest grids.
constexpr float kLift = 2e-3f;
/// Shares of the progress: listing the cells, and fitting the compression.
constexpr double kListed = 0.03, kFitted = 0.35;
/// An existing compression is replaced when it loses more than this share of the new cells' energy.
double max_loss(double fit_loss) { return 2.0 * fit_loss + 0.01; }
/// Incremented when the vectors change for the same input.
constexpr std::uint64_t kAlgorithm = 7;
/// Samples of a cell share one BRDF when their normals (cosine: 0.03 rad) and colours differ by less than this.
constexpr double kOneNormal = 0.99955;
constexpr float kOneColor = 0.01f;

/// Scale of the light part of a normalised vector: that of the area part of a cell that is seen from everywhere.
constexpr float kLightSize = 2.5f;

/// Area of each material and the mean colour over a range of pieces.
struct NodeContent {
  int material = -1;  ///< the only material of the cell; -1: mixed
  bool glows = false;
  glm::vec3 color{1.0f};
};

/// A node of a brick and its range of pieces.
struct BrickCell {
  std::uint32_t node = 0;
  glm::ivec3 lower{0};  ///< in finest cells from the root's corner
  int size = 1;         ///< in finest cells
  std::size_t begin = 0, end = 0;
  NodeContent content;
  bool planar = false;
  bool own() const { return !planar || content.material < 0; }
};

class BrickCells {
 public:
  BrickCells(const CellBrdfSource& source, const OctreePieces& pieces, std::uint32_t code)
      : source_(source), brick_(source.bricks.bricks.at(code).brick), pieces_(pieces.of_brick(code)) {
    const OctreeGrid& grid = source.bricks.grid;
    const int levels = grid.depth - grid.brick_level;
    std::erase_if(pieces_, [](const OctreePiece& p) { return p.opacity <= 0.0f; });
    if (brick_.counts.empty()) return;
    glm::ivec3 lower(0);
    for (int bit = 0; bit < 10; ++bit)
      for (int axis = 0; axis < 3; ++axis) lower[axis] |= static_cast<int>(code >> (3 * bit + axis) & 1u) << bit;
    lower <<= levels;
    std::vector<std::uint32_t> codes{0u}, next;
    std::uint32_t node = 0;
    for (int level = 0; level <= levels && !codes.empty(); ++level) {
      next.clear();
      for (const std::uint32_t c : codes) {
        const std::uint8_t mask = brick_.masks[node];
        for (std::uint32_t k = 0; k < 8; ++k)
          if (mask >> k & 1u) next.push_back(c << 3 | k);
        add(node++, c, level, levels, lower);
      }
      codes.swap(next);
    }
  }

  const std::vector<BrickCell>& cells() const { return cells_; }
  glm::vec3 normal(const BrickCell& cell) const {
    return glm::normalize(shared::octree_unpack_plane(brick_.words[cell.node].plane).normal);
  }

  /// The vector of one cell, in its own frame.
  struct Baked {
    Eigen::VectorXf vector;
    CellRotation turn;
  };
  Baked bake(const BrickCell& cell, const CellRays& rays, int samples) const {
    std::vector<const ClipPolygon*> polygons;
    std::vector<CellReflectance> reflectance;
    for (std::size_t i = cell.begin; i < cell.end; ++i) polygons.push_back(&pieces_[i].polygon);
    const double side = cell.size;
    auto points = sample_polygons(polygons, side * side, samples, cell.node);
    group_samples(cell, &points, &reflectance);
    const glm::vec3 low(cell.lower), high(cell.lower + cell.size);
    const CellVisibility visible = [&](const CellSample& s, const glm::vec3& d) {
      const glm::vec3 n(s.normal);
      const glm::vec3 from = glm::vec3(s.position) + (glm::dot(n, d) < 0.0f ? -kLift : kLift) * n;
      float distance = 1e30f;
      for (int axis = 0; axis < 3; ++axis)
        if (d[axis] != 0.0f)
          distance = std::min(distance, ((d[axis] > 0.0f ? high : low)[axis] - from[axis]) / d[axis]);
      return rays.free(from, d, distance);
    };
    const CellRotation turn = find_cell_rotation(points, normal(cell));
    const glm::mat3 frame = cell_frame(normal(cell), turn);
    return {compute_cell_brdf(points, reflectance, frame, cell.planar ? CellVisibility{} : visible), turn};
  }
  /// Groups samples of one material and colour with almost the same normal, to share one BRDF: the directions are 0.36
  /// rad apart. `piece` becomes the group.
  void group_samples(const BrickCell& cell, std::vector<CellSample>* points,
                     std::vector<CellReflectance>* reflectance) const {
    struct Group {
      int material;
      glm::vec3 color{};
      glm::dvec3 normal{};
    };
    std::vector<Group> groups;
    for (CellSample& s : *points) {
      const OctreePiece& p = pieces_[cell.begin + static_cast<std::size_t>(s.piece)];
      const auto same = std::find_if(groups.begin(), groups.end(), [&](const Group& g) {
        return g.material == p.material && glm::dot(g.normal, s.normal) > kOneNormal &&
               glm::length(g.color - p.color) < kOneColor;
      });
      s.piece = static_cast<int>(same - groups.begin());
      if (same != groups.end()) continue;
      groups.push_back({p.material, p.color, s.normal});
      reflectance->push_back(material(p.material).fast_brdf(p.color));
    }
    std::stable_sort(points->begin(), points->end(),
                     [](const CellSample& a, const CellSample& b) { return a.piece < b.piece; });
  }
  const CellMaterial& material(int index) const {
    const auto k = static_cast<std::size_t>(index);
    return k < source_.materials.size() ? source_.materials[k] : source_.materials.back();
  }
  /// Hash of everything that the codes depend on, except the compression.
  std::uint64_t key(std::uint64_t brick_key) const {
    std::vector<std::uint64_t> words{kAlgorithm, brick_key};
    std::vector<int> used;
    for (const OctreePiece& p : pieces_)
      if (used.empty() || used.back() != p.material) used.push_back(p.material);
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    for (int m : used) words.push_back(material(m).content());
    return content_hash(std::as_bytes(std::span(words)));
  }

 private:
  void add(std::uint32_t node, std::uint32_t code, int level, int levels, const glm::ivec3& brick_lower) {
    const int shift = 3 * (levels - level);
    const auto before = [&](const OctreePiece& p, std::uint32_t c) { return (p.code >> shift) < c; };
    BrickCell cell;
    cell.begin =
        static_cast<std::size_t>(std::lower_bound(pieces_.begin(), pieces_.end(), code, before) - pieces_.begin());
    cell.end =
        static_cast<std::size_t>(std::lower_bound(pieces_.begin(), pieces_.end(), code + 1u, before) - pieces_.begin());
    if (cell.begin == cell.end) return;
    cell.node = node;
    cell.size = 1 << (levels - level);
    for (int bit = 0; bit < level; ++bit)
      for (int axis = 0; axis < 3; ++axis) cell.lower[axis] |= static_cast<int>(code >> (3 * bit + axis) & 1u) << bit;
    cell.lower = cell.lower * cell.size + brick_lower;
    cell.planar = shared::octree_unpack_plane(brick_.words[node].plane).planar;
    cell.content = content_of(cell);
    if (!cell.content.glows) cells_.push_back(cell);
  }

  NodeContent content_of(const BrickCell& cell) const {
    std::map<int, double> areas;
    double total = 0.0;
    glm::dvec3 color(0.0);
    NodeContent content;
    for (std::size_t i = cell.begin; i < cell.end; ++i) {
      const double area = glm::length(polygon_area_vector(pieces_[i].polygon));
      areas[pieces_[i].material] += area;
      color += area * glm::dvec3(pieces_[i].color);
      total += area;
      content.glows = content.glows || material(pieces_[i].material).glows();
    }
    const auto largest =
        std::max_element(areas.begin(), areas.end(), [](auto& a, auto& b) { return a.second < b.second; });
    if (largest->second >= (1.0 - kSecondMaterial) * total) content.material = largest->first;
    if (total > 0.0) content.color = glm::vec3(color / total);
    return content;
  }

  const CellBrdfSource& source_;
  const OctreeBrick& brick_;
  std::vector<OctreePiece> pieces_;
  std::vector<BrickCell> cells_;
};

/// Colours with the precision of the nodes' colour words.
using SharedKey = std::pair<int, std::uint32_t>;
SharedKey shared_key(const NodeContent& content) {
  return {content.material, shared::octree_pack_color(0, 0.0f, content.color)};
}

/// Vector of a flat unit square of one material.
Eigen::VectorXf bake_flat(const CellMaterial& material, const SharedKey& key) {
  const glm::vec3 color = shared::octree_unpack_color(key.second).tint;
  const CellSample sample{glm::dvec3(0.0), glm::dvec3(0.0, 0.0, 1.0), 1.0, 0};
  const CellReflectance f = material.fast_brdf(color);
  return compute_cell_brdf(std::span(&sample, 1), std::span(&f, 1), glm::mat3(1.0f), {});
}

class CellBake {
 public:
  CellBake(const CellBrdfSource& source, const CellBrdfOptions& options, const CellBrdfs* before,
           const CellBrdfProgress& progress)
      : source_(source),
        options_(options),
        before_(before),
        progress_(progress),
        pieces_(source.source, source.bricks.grid),
        rays_(source.source, source.bricks.grid) {
    for (const auto& [code, entry] : source.bricks.bricks)
      if (!entry.brick.counts.empty()) codes_.push_back(code);
  }

  std::optional<CellBrdfs> run() {
    if (before_ && before_->pca.cluster_count() > 0) {
      out_.pca = before_->pca;
      out_.fit_loss = before_->fit_loss;
      encode_all(0.0);
      if (cancelled()) return std::nullopt;
      const bool serves = out_.reused > 0 && out_.light_error <= max_loss(before_->fit_loss) * out_.light_energy;
      if (out_.baked_cells == 0 || serves) return std::move(out_);
      // The compression was made for another scene: start again with a new one.
      before_ = nullptr;
      out_ = {};
      flat_.clear();
      if (progress_.refit) progress_.refit();
    }
    if (!fit()) return std::nullopt;
    encode_all(kFitted);
    if (cancelled()) return std::nullopt;
    return std::move(out_);
  }

 private:
  void encode_all(double begin) {
    std::size_t done = 0;
    parallel_for(std::size_t{0}, codes_.size(), [&](std::size_t i) {
      if (cancelled()) return;
      const BrickCells cells(source_, pieces_, codes_[i]);
      const std::uint64_t key = cells.key(source_.bricks.bricks.at(codes_[i]).key);
      const CellBrdfs::Brick* old = find(codes_[i]);
      const bool reuse = old && old->key == key;
      CellBrdfs::Brick brick = reuse ? *old : encode(cells, key);
      if (cancelled()) return;
      const std::lock_guard lock(mutex_);
      out_.reused += reuse;
      if (!reuse && progress_.finished) progress_.finished(out_, codes_[i], brick);
      out_.bricks[codes_[i]] = std::move(brick);
      report(begin + (1.0 - begin) * static_cast<double>(++done) / static_cast<double>(codes_.size()));
    });
  }

  bool cancelled() const { return progress_.cancel && *progress_.cancel; }
  void report(double fraction) const {
    if (progress_.report) progress_.report(fraction);
  }
  const CellBrdfs::Brick* find(std::uint32_t code) const {
    if (!before_) return nullptr;
    const auto found = before_->bricks.find(code);
    return found == before_->bricks.end() ? nullptr : &found->second;
  }

  struct Training {
    std::vector<std::pair<std::size_t, std::uint32_t>> own;  ///< index in codes_, node
    std::map<SharedKey, const CellMaterial*> flat;
  };
  Training list() {
    Training training;
    std::vector<std::vector<std::uint32_t>> own(codes_.size());
    std::size_t done = 0;
    parallel_for(std::size_t{0}, codes_.size(), [&](std::size_t i) {
      if (cancelled()) return;
      const BrickCells cells(source_, pieces_, codes_[i]);
      std::map<SharedKey, const CellMaterial*> flat;
      for (const BrickCell& cell : cells.cells()) {
        if (cell.own())
          own[i].push_back(cell.node);
        else
          flat.emplace(shared_key(cell.content), &cells.material(cell.content.material));
      }
      const std::lock_guard lock(mutex_);
      training.flat.merge(flat);
      report(kListed * static_cast<double>(++done) / static_cast<double>(codes_.size()));
    });
    for (std::size_t i = 0; i < own.size(); ++i)
      for (const std::uint32_t node : own[i]) training.own.emplace_back(i, node);
    std::mt19937 random(1);
    const std::size_t wanted = std::min(training.own.size(), static_cast<std::size_t>(options_.training));
    for (std::size_t i = 0; i < wanted; ++i)
      std::swap(training.own[i], training.own[i + random() % (training.own.size() - i)]);
    training.own.resize(wanted);
    std::sort(training.own.begin(), training.own.end());
    return training;
  }

  /// Returns false when cancelled.
  bool fit() {
    const Training training = list();
    const std::size_t max_flat = static_cast<std::size_t>(options_.training) / 4;
    const std::size_t flat = std::min(training.flat.size(), max_flat);
    Eigen::MatrixXf vectors(kCellBrdfDimension, static_cast<Eigen::Index>(training.own.size() + flat));
    if (vectors.cols() == 0) return !cancelled();
    std::vector<std::size_t> begins;  // first cell of each brick
    for (std::size_t k = 0; k < training.own.size(); ++k)
      if (k == 0 || training.own[k].first != training.own[k - 1].first) begins.push_back(k);
    begins.push_back(training.own.size());
    std::size_t done = 0;
    parallel_for(std::size_t{0}, begins.size() - 1, [&](std::size_t b) {
      if (cancelled()) return;
      const BrickCells cells(source_, pieces_, codes_[training.own[begins[b]].first]);
      std::size_t at = 0;
      for (std::size_t k = begins[b]; k < begins[b + 1] && !cancelled(); ++k) {
        while (cells.cells()[at].node != training.own[k].second) ++at;
        vectors.col(static_cast<Eigen::Index>(k)) = cells.bake(cells.cells()[at], rays_, options_.samples).vector;
      }
      const std::lock_guard lock(mutex_);
      done += begins[b + 1] - begins[b];
      report(kListed +
             0.5 * (kFitted - kListed) * static_cast<double>(done) / static_cast<double>(training.own.size()));
    });
    auto column = static_cast<Eigen::Index>(training.own.size());
    for (const auto& [key, material] : training.flat)
      if (column < vectors.cols()) vectors.col(column++) = bake_flat(*material, key);
    if (cancelled()) return false;
    for (Eigen::Index k = 0; k < vectors.cols(); ++k) {
      Eigen::VectorXf vector = vectors.col(k);
      normalise_cell_brdf(&vector);
      vectors.col(k) = vector;
    }
    out_.pca = LocalPca::fit(vectors, cell_brdf_measure(),
                             {.clusters = options_.clusters,
                              .components = options_.components,
                              .rounds = 8,
                              .least_gain = 1e-2,
                              .stop = [&] { return cancelled(); }});
    for (Eigen::Index k = 0; k < vectors.cols(); ++k)
      count_error(vectors.col(k), out_.pca.decode(out_.pca.encode(vectors.col(k))));
    out_.fit_loss = out_.light_energy > 0.0 ? out_.light_error / out_.light_energy : 0.0;
    out_.light_error = out_.light_energy = out_.area_error = out_.area_energy = 0.0;
    return !cancelled();
  }

  /// Encodes normalised vectors.
  std::vector<CellBrdfCode> codes_of(Eigen::MatrixXf vectors, bool shared) {
    std::vector<CellBrdfCode> codes(static_cast<std::size_t>(vectors.cols()));
    for (std::size_t i = 0; i < codes.size(); ++i) {
      Eigen::VectorXf vector = vectors.col(static_cast<Eigen::Index>(i));
      codes[i].scale = normalise_cell_brdf(&vector);
      vectors.col(static_cast<Eigen::Index>(i)) = vector;
    }
    const std::vector<LocalPcaCode> found = out_.pca.encode_all(vectors);
    for (std::size_t i = 0; i < codes.size(); ++i) {
      count_error(vectors.col(static_cast<Eigen::Index>(i)), out_.pca.decode(found[i]));
      codes[i].cluster = static_cast<std::uint32_t>(found[i].cluster);
      for (Eigen::Index k = 0; k < std::min<Eigen::Index>(found[i].weights.size(), 4); ++k)
        codes[i].weights[static_cast<std::size_t>(k)] = found[i].weights[k];
      codes[i].shared = shared;
    }
    return codes;
  }

  void count_error(const Eigen::VectorXf& vector, const Eigen::VectorXf& decoded) {
    const Eigen::VectorXf squares = (vector - decoded).cwiseAbs2(), whole = vector.cwiseAbs2();
    constexpr Eigen::Index kLight = 3 * shared::kCellPairs, kArea = shared::kCellDirections;
    const std::lock_guard lock(mutex_);
    out_.light_error += static_cast<double>(measure_.head(kLight).dot(squares.head(kLight)));
    out_.light_energy += static_cast<double>(measure_.head(kLight).dot(whole.head(kLight)));
    out_.area_error += static_cast<double>(measure_.tail(kArea).dot(squares.tail(kArea)));
    out_.area_energy += static_cast<double>(measure_.tail(kArea).dot(whole.tail(kArea)));
  }

  CellBrdfCode flat_code(const NodeContent& content, const CellMaterial& material) {
    const SharedKey key = shared_key(content);
    {
      const std::lock_guard lock(mutex_);
      if (const auto found = flat_.find(key); found != flat_.end()) return found->second;
    }
    const CellBrdfCode code = codes_of(bake_flat(material, key), true).front();
    const std::lock_guard lock(mutex_);
    out_.baked_cells += flat_.emplace(key, code).second;
    return code;
  }

  CellBrdfs::Brick encode(const BrickCells& cells, std::uint64_t key) {
    CellBrdfs::Brick brick;
    brick.key = key;
    std::map<SharedKey, std::uint32_t> flat;
    std::size_t baked = 0;
    Eigen::MatrixXf vectors(kCellBrdfDimension, kBatchSize);
    std::vector<std::size_t> pending;  // entries of the table that belong to these vectors
    const auto compress = [&] {
      if (pending.empty()) return;
      const auto codes = codes_of(vectors.leftCols(static_cast<Eigen::Index>(pending.size())), false);
      for (std::size_t i = 0; i < pending.size(); ++i) {
        const CellRotation turn = brick.table[pending[i]].turn;
        brick.table[pending[i]] = codes[i];
        brick.table[pending[i]].turn = turn;
      }
      pending.clear();
    };
    for (const BrickCell& cell : cells.cells()) {
      if (cancelled()) break;
      auto index = static_cast<std::uint32_t>(brick.table.size());
      if (cell.own()) {
        BrickCells::Baked baked_cell = cells.bake(cell, rays_, options_.samples);
        vectors.col(static_cast<Eigen::Index>(pending.size())) = baked_cell.vector;
        pending.push_back(index);
        brick.table.emplace_back().turn = baked_cell.turn;
        ++baked;
        if (pending.size() == kBatchSize) compress();
      } else {
        const auto [found, added] = flat.emplace(shared_key(cell.content), index);
        if (added) brick.table.push_back(flat_code(cell.content, cells.material(cell.content.material)));
        index = found->second;
      }
      brick.nodes.push_back(cell.node);
      brick.codes.push_back(index);
    }
    compress();
    const std::lock_guard lock(mutex_);
    out_.baked_cells += baked;
    return brick;
  }

  const CellBrdfSource& source_;
  const CellBrdfOptions& options_;
  const CellBrdfs* before_;
  const CellBrdfProgress& progress_;
  OctreePieces pieces_;
  CellRays rays_;
  std::vector<std::uint32_t> codes_;
  std::map<SharedKey, CellBrdfCode> flat_;
  const Eigen::VectorXf measure_ = cell_brdf_measure();
  std::mutex mutex_;
  CellBrdfs out_;
};

}  // namespace

float normalise_cell_brdf(Eigen::VectorXf* vector) {
  static const Eigen::VectorXf measure = cell_brdf_measure();
  auto light = vector->head(3 * shared::kCellPairs);
  const float size = std::sqrt(measure.head(light.size()).dot(light.cwiseAbs2())) / kLightSize;
  if (size > 0.0f) light /= size;
  return size;
}

std::size_t CellBrdfs::cell_count() const {
  std::size_t sum = 0;
  for (const auto& [code, brick] : bricks) sum += brick.nodes.size();
  return sum;
}

std::size_t CellBrdfs::shared_count() const {
  std::size_t sum = 0;
  for (const auto& [code, brick] : bricks)
    for (const std::uint32_t c : brick.codes) sum += brick.table[c].shared;
  return sum;
}

std::optional<CellBrdfs> bake_cell_brdfs(const CellBrdfSource& source, const CellBrdfOptions& options,
                                         const CellBrdfs* before, const CellBrdfProgress& progress) {
  return CellBake(source, options, before, progress).run();
}

}  // namespace maquette
