#include "render/octree/octree_build.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <mutex>
#include <span>

#include "render/octree/octree_clip.h"
#include "render/octree/octree_triangles.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/luminance.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

std::uint32_t encode_morton(const glm::ivec3& p) {
  std::uint32_t code = 0;
  for (int bit = 0; bit < 10; ++bit)
    for (int axis = 0; axis < 3; ++axis) code |= (static_cast<std::uint32_t>(p[axis]) >> bit & 1u) << (3 * bit + axis);
  return code;
}

glm::ivec3 decode_brick(std::uint32_t code) {
  glm::ivec3 p(0);
  for (int bit = 0; bit < 10; ++bit)
    for (int axis = 0; axis < 3; ++axis) p[axis] |= static_cast<int>(code >> (3 * bit + axis) & 1u) << bit;
  return p;
}

struct Triangle {
  std::uint32_t first_index = 0, item = 0;
};

// A cell is too detailed for one normal, one material and one colour when it exceeds any of these limits.
// 1 - |mean of its normals|: the normals of a tube are 12 degrees to either side of their mean.
constexpr double kSpread = 0.0075;
/// Share of its area that does not belong to its main material.
constexpr double kOtherMaterial = 0.04;
/// Brightest over darkest colour, in stops; anything darker than kDark counts as black.
constexpr double kStops = 0.6;
constexpr float kDark = 0.02f;
/// Share of a face by which the plane of a surface extends into the cell beyond the end of the surface.
constexpr double kOpenShare = 0.1;
/// At most one in this many cells of a brick is split, so that a wrinkled scene does not exhaust the memory.
constexpr std::size_t kSplitShare = 2;

/// Triangles sorted into the bricks that their bounds touch.
struct Bins {
  std::vector<std::uint32_t> begin;  ///< by Morton code
  std::vector<Triangle> triangles;
};

class Builder {
 public:
  Builder(const OctreeSource& source, const OctreeGrid& grid)
      : source_(source),
        grid_(grid),
        cells_per_m_(std::exp2(grid.depth) / grid.side_m),
        levels_(grid.depth - grid.brick_level) {
    for (const Bounds& box : grid.fine) {
      fine_.push_back({glm::vec3((glm::dvec3(box.min) - grid.corner) * cells_per_m_),
                       glm::vec3((glm::dvec3(box.max) - grid.corner) * cells_per_m_)});
    }
    constexpr double kAlgorithm = 6.0;  // incremented when the same triangles give other nodes
    const double setup[] = {kAlgorithm, grid.corner.x, grid.corner.y, grid.corner.z, grid.side_m};
    const int levels = 64 * (64 * grid.detail + grid.depth) + grid.rest_depth;
    setup_ = content_hash(std::as_bytes(std::span(setup)), static_cast<std::uint64_t>(levels));
    setup_ = content_hash(std::as_bytes(std::span(fine_)), setup_);
  }

  Bins bin() const {
    const int side = 1 << grid_.brick_level;
    Bins bins;
    std::vector<std::uint32_t> counts(std::size_t{1} << 3 * grid_.brick_level, 0u);
    const auto each_brick = [&](std::size_t first, auto&& visit) {
      glm::ivec3 low(side), high(-1);
      for (std::size_t k = 0; k < 3; ++k) {
        const glm::ivec3 p(glm::floor(to_cells(source_.geometry.indices[first + k]) / std::exp2(levels_)));
        low = glm::min(low, p);
        high = glm::max(high, p);
      }
      low = glm::clamp(low, 0, side - 1);
      high = glm::clamp(high, 0, side - 1);
      for (int z = low.z; z <= high.z; ++z)
        for (int y = low.y; y <= high.y; ++y)
          for (int x = low.x; x <= high.x; ++x) visit(encode_morton({x, y, z}));
    };
    for_each_triangle(source_, [&](std::size_t first, std::size_t) {
      each_brick(first, [&](std::uint32_t brick) { ++counts[brick]; });
    });
    bins.begin.assign(counts.size() + 1, 0u);
    for (std::size_t b = 0; b < counts.size(); ++b) bins.begin[b + 1] = bins.begin[b] + counts[b];
    bins.triangles.resize(bins.begin.back());
    std::vector<std::uint32_t> next(bins.begin.begin(), bins.begin.end() - 1);
    for_each_triangle(source_, [&](std::size_t first, std::size_t item) {
      each_brick(first, [&](std::uint32_t brick) {
        bins.triangles[next[brick]++] = {static_cast<std::uint32_t>(first), static_cast<std::uint32_t>(item)};
      });
    });
    return bins;
  }

  /// Hash of all inputs of the brick.
  std::uint64_t key(std::span<const Triangle> triangles) const {
    std::vector<float> data;
    const FlatGeometry& g = source_.geometry;
    std::uint64_t hash = setup_;
    for (const Triangle& t : triangles) {
      const int material = source_.materials[t.item];
      const bool textured = source_.textures.textured(material);
      for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t v = g.indices[t.first_index + k];
        const glm::vec4& c = g.colors[v];
        data.insert(data.end(), {g.positions[v].x, g.positions[v].y, g.positions[v].z, g.normals[v].x, g.normals[v].y,
                                 g.normals[v].z, c.r, c.g, c.b, c.a});
        if (!textured) continue;
        const glm::vec2 uv = source_.textures.uv_set(material) == 1 ? g.uv1[v] : g.uv0[v];
        data.insert(data.end(), {uv.x, uv.y});
      }
      const std::uint64_t words[] = {static_cast<std::uint64_t>(material), source_.textures.content(material),
                                     t.first_index};
      float all[6];
      std::memcpy(all, words, sizeof all);
      data.insert(data.end(), all, all + 6);
      if (data.size() > 65536) {
        hash = content_hash(std::as_bytes(std::span(data)), hash);
        data.clear();
      }
    }
    return content_hash(std::as_bytes(std::span(data)), hash);
  }

  glm::ivec3 brick_lower(std::uint32_t code) const { return decode_brick(code) << levels_; }

  /// The pieces of all triangles in the leaves of a brick.
  OctreeFragments clip(std::uint32_t code, std::span<const Triangle> triangles) const {
    const glm::ivec3 lower = brick_lower(code);
    const CellClipper::IsLeaf is_leaf = [&](const glm::ivec3& at, int level) { return this->is_leaf(at, level); };
    Triangle current;
    OctreeFragments out;
    const std::function<void(const CellClipper::Piece&)> emit = [&](const CellClipper::Piece& piece) {
      add_fragment(piece, lower, current, &out);
    };
    const CellClipper clipper(grid_.depth, is_leaf, emit);
    for (const Triangle& t : triangles) {
      current = t;
      ClipPolygon polygon;
      polygon.count = 3;
      for (std::size_t k = 0; k < 3; ++k) polygon.corners[k] = to_cells(source_.geometry.indices[t.first_index + k]);
      clipper.clip(polygon, lower, grid_.brick_level);
    }
    for (int level = grid_.depth - grid_.detail; level < grid_.depth; ++level) split_cells(lower, level, &out);
    return out;
  }

  OctreeBrick build(std::uint32_t code, std::span<const Triangle> triangles) const {
    OctreeFragments fragments = clip(code, triangles);
    return build_brick(&fragments, levels_);
  }

 private:
  glm::dvec3 to_cells(std::uint32_t vertex) const {
    return (glm::dvec3(source_.geometry.positions[vertex]) - grid_.corner) * cells_per_m_;
  }

  bool is_leaf(const glm::ivec3& lower, int level) const {
    if (level == grid_.depth - grid_.detail) return true;
    if (level < grid_.rest_depth || fine_.empty()) return false;
    const glm::vec3 low(lower), high(lower + (1 << (grid_.depth - level)));
    return std::none_of(fine_.begin(), fine_.end(), [&](const Box& box) {
      return glm::all(glm::lessThanEqual(box.low, high)) && glm::all(glm::greaterThanEqual(box.high, low));
    });
  }

  /// A triangle prepared for interpolation.
  struct Face {
    std::uint32_t v[3];
    glm::dvec3 p[3]{};
    glm::dvec3 normal{};  ///< its length is twice the area
    double square;        ///< of that
  };
  Face face_of(std::uint32_t first_index) const {
    Face face;
    for (std::size_t k = 0; k < 3; ++k) face.p[k] = to_cells(face.v[k] = source_.geometry.indices[first_index + k]);
    face.normal = glm::cross(face.p[1] - face.p[0], face.p[2] - face.p[0]);
    face.square = glm::dot(face.normal, face.normal);
    return face;
  }
  static glm::vec3 weights_at(const Face& face, const glm::dvec3& p) {
    const double b1 = glm::dot(glm::cross(p - face.p[0], face.p[2] - face.p[0]), face.normal) / face.square;
    const double b2 = glm::dot(glm::cross(face.p[1] - face.p[0], p - face.p[0]), face.normal) / face.square;
    return glm::vec3(1.0 - b1 - b2, b1, b2);
  }
  template <typename T>
  static T blend(const std::vector<T>& values, const Face& face, const glm::vec3& w) {
    return w[0] * values[face.v[0]] + w[1] * values[face.v[1]] + w[2] * values[face.v[2]];
  }
  /// Width in UV of `area` of the face.
  float uv_span(const std::vector<glm::vec2>& uvs, const Face& face, float area) const {
    const glm::vec2 e1 = uvs[face.v[1]] - uvs[face.v[0]], e2 = uvs[face.v[2]] - uvs[face.v[0]];
    return std::sqrt(std::abs(e1.x * e2.y - e1.y * e2.x) * area / static_cast<float>(std::sqrt(face.square)));
  }
  const std::vector<glm::vec2>& uvs_of(int material) const {
    return source_.textures.uv_set(material) == 1 ? source_.geometry.uv1 : source_.geometry.uv0;
  }

  void add_fragment(const CellClipper::Piece& piece, const glm::ivec3& brick_lower, const Triangle& triangle,
                    OctreeFragments* out) const {
    const FlatGeometry& g = source_.geometry;
    OctreeFragment f;
    f.item = triangle.item;
    f.first_corner = static_cast<std::uint32_t>(out->corners.size());
    f.corner_count = static_cast<std::uint32_t>(piece.polygon->count);
    for (int i = 0; i < piece.polygon->count; ++i)
      out->corners.emplace_back(piece.polygon->corners[i] - glm::dvec3(brick_lower));
    f.code = encode_morton(piece.lower - brick_lower);
    f.level = piece.level - grid_.brick_level;
    const int material = source_.materials[triangle.item];
    f.material = static_cast<std::uint32_t>(material);
    f.triangle = triangle.first_index / 3;
    const glm::dvec3 area = polygon_area_vector(*piece.polygon), centroid = polygon_centroid(*piece.polygon);
    f.area = static_cast<float>(glm::length(area));
    f.centroid = glm::vec3(centroid - glm::dvec3(brick_lower));
    const Face face = face_of(triangle.first_index);
    f.geometric = glm::vec3(face.normal / std::sqrt(face.square));
    const glm::vec3 w = weights_at(face, centroid);
    const glm::vec3 smooth = blend(g.normals, face, w);
    const float length = glm::length(smooth);
    f.normal = length > 1e-6f ? smooth / length : f.geometric;
    const glm::vec4 vertex_color = blend(g.colors, face, w);
    f.color = glm::vec3(vertex_color);
    float alpha = source_.textures.alpha_factor(material) * vertex_color.a;
    if (source_.textures.textured(material)) {
      const std::vector<glm::vec2>& uvs = uvs_of(material);
      const glm::vec4 texel = source_.textures.mean_color(material, blend(uvs, face, w), uv_span(uvs, face, f.area));
      f.color *= glm::vec3(texel);
      alpha *= texel.a;
    }
    if (source_.textures.cut_out(material)) f.opacity = alpha < source_.textures.cutoff(material) ? 0.0f : 1.0f;
    out->pieces.push_back(f);
  }

  /// Brightest over darkest colour of a cell's pieces, in stops; textures are sampled at a few points of each piece.
  double contrast_of(std::span<const OctreeFragment> pieces, std::span<const glm::vec3> corners,
                     const glm::dvec3& brick_lower) const {
    float low = std::numeric_limits<float>::max(), high = 0.0f;
    const auto add = [&](const glm::vec3& color) {
      const float value = luminance(color) + kDark;
      low = std::min(low, value);
      high = std::max(high, value);
    };
    for (const OctreeFragment& f : pieces) {
      const int material = static_cast<int>(f.material);
      if (f.opacity == 0.0f) continue;
      if (!source_.textures.textured(material)) {
        add(f.color);
        continue;
      }
      const Face face = face_of(3 * f.triangle);
      const std::vector<glm::vec2>& uvs = uvs_of(material);
      const float span = 0.25f * uv_span(uvs, face, f.area);
      for (const glm::vec3& corner : corners.subspan(f.first_corner, f.corner_count)) {
        for (const float t : {0.3f, 0.6f, 0.9f}) {
          const glm::dvec3 p = glm::dvec3(glm::mix(f.centroid, corner, t)) + brick_lower;
          const glm::vec3 w = weights_at(face, p);
          add(glm::vec3(source_.textures.mean_color(material, blend(uvs, face, w), span)));
        }
      }
    }
    return high > 0.0f ? static_cast<double>(std::log2(high / low)) : 0.0;
  }

  /// At least 1 when one normal, one material and one colour cannot represent the cell.
  double detail_of(std::span<const OctreeFragment> pieces, std::span<const glm::vec3> corners,
                   const glm::dvec3& brick_lower) const {
    const auto largest =
        std::max_element(pieces.begin(), pieces.end(), [](auto& a, auto& b) { return a.area < b.area; });
    double all = 0.0, same = 0.0;
    glm::dvec3 normal(0.0), centroid(0.0);
    for (const OctreeFragment& f : pieces) {
      const auto area = static_cast<double>(f.area);
      all += area;
      centroid += area * glm::dvec3(f.centroid);
      if (f.material == largest->material) same += area;
      // The two sides of a thin sheet stay in one cell however fine the cells are, so their normals get one
      // orientation.
      normal += (glm::dot(f.normal, largest->normal) < 0.0f ? -area : area) * glm::dvec3(f.normal);
    }
    const double spread = 1.0 - glm::length(normal) / all;
    const double size = std::exp2(levels_ - pieces[0].level);
    const double section = plane_section_area(normal, centroid / all, glm::dvec3(decode_brick(pieces[0].code)), size);
    return std::max({spread / kSpread, (1.0 - same / all) / kOtherMaterial,
                     (section - all) / (kOpenShare * size * size), contrast_of(pieces, corners, brick_lower) / kStops});
  }

  /// Splits cells of `level` with much detail into eight, the most detailed first, while the budget lasts.
  void split_cells(const glm::ivec3& brick_lower, int level, OctreeFragments* fragments) const {
    std::vector<OctreeFragment>& pieces = fragments->pieces;
    std::sort(pieces.begin(), pieces.end(), [](auto& a, auto& b) { return a.code < b.code; });
    struct Cell {
      double detail;
      std::size_t first, end;
    };
    std::vector<Cell> cells;
    std::size_t count = 0;
    for (std::size_t first = 0, end = 0; first < pieces.size(); first = end) {
      for (end = first + 1; end < pieces.size() && pieces[end].code == pieces[first].code;) ++end;
      ++count;
      if (pieces[first].level != level - grid_.brick_level) continue;
      const double detail = detail_of(std::span(pieces).subspan(first, end - first), fragments->corners, brick_lower);
      if (detail >= 1.0) cells.push_back({detail, first, end});
    }
    const std::size_t room = count / kSplitShare;
    if (cells.size() > room) {
      const auto middle = cells.begin() + static_cast<std::ptrdiff_t>(room);
      std::nth_element(cells.begin(), middle, cells.end(),
                       [](auto& a, auto& b) { return a.detail != b.detail ? a.detail > b.detail : a.first < b.first; });
      cells.erase(middle, cells.end());
    }
    if (cells.empty()) return;
    OctreeFragments out;
    std::vector<bool> split(pieces.size(), false);
    const CellClipper::IsLeaf is_leaf = [&](const glm::ivec3&, int at) { return at == level + 1; };
    Triangle current;
    const std::function<void(const CellClipper::Piece&)> emit = [&](const CellClipper::Piece& piece) {
      add_fragment(piece, brick_lower, current, &out);
    };
    const CellClipper clipper(grid_.depth, is_leaf, emit);
    for (const Cell& cell : cells) {
      for (std::size_t i = cell.first; i < cell.end; ++i) {
        const OctreeFragment& f = pieces[i];
        split[i] = true;
        ClipPolygon polygon;
        polygon.count = static_cast<int>(f.corner_count);
        for (std::uint32_t k = 0; k < f.corner_count; ++k)
          polygon.corners[k] = glm::dvec3(fragments->corners[f.first_corner + k]) + glm::dvec3(brick_lower);
        current = {3 * f.triangle, f.item};
        clipper.clip(polygon, decode_brick(f.code) + brick_lower, level);
      }
    }
    // Pieces of cells that are not split keep their corners.
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      if (split[i]) continue;
      OctreeFragment f = pieces[i];
      const auto corners = fragments->corners.begin() + f.first_corner;
      f.first_corner = static_cast<std::uint32_t>(out.corners.size());
      out.corners.insert(out.corners.end(), corners, corners + f.corner_count);
      out.pieces.push_back(f);
    }
    *fragments = std::move(out);
  }

  struct Box {
    glm::vec3 low{}, high{};
  };
  const OctreeSource& source_;
  const OctreeGrid& grid_;
  double cells_per_m_;
  int levels_ = 0;
  std::vector<Box> fine_;
  std::uint64_t setup_ = 0;
};

/// Counts the nodes of every level while bricks are finished, so that an error can name the depth that fits.
class NodeBudget {
 public:
  explicit NodeBudget(std::size_t max_nodes) : max_nodes_(max_nodes) {}
  /// True while all nodes so far fit. Callers hold a lock.
  bool add(const OctreeBrick& brick) {
    for (std::size_t l = 0; l < brick.counts.size(); ++l) {
      levels_[l] += brick.counts[l];
      total_ += brick.counts[l];
    }
    return total_ <= max_nodes_;
  }
  /// Throws Error when the nodes do not fit. `outer`: levels of the grid above those that the setting counts.
  void check(const OctreeGrid& grid, int outer) const {
    if (total_ <= max_nodes_) return;
    std::size_t sum = 0;
    int fits = grid.brick_level - outer;
    for (int level = grid.brick_level; level <= grid.depth; ++level) {
      sum += levels_[static_cast<std::size_t>(level - grid.brick_level)];
      if (sum <= max_nodes_) fits = level - outer;
    }
    throw Error("octree.depth",
                std::to_string(grid.depth - outer) + " levels of this scene are " + std::to_string(total_) +
                    " nodes; a storage buffer takes " + std::to_string(max_nodes_),
                "depth " + std::to_string(fits) + " fits: --set octree.depth=" + std::to_string(fits));
  }

 private:
  std::size_t max_nodes_;
  std::array<std::size_t, kOctreeMaxLevels + 1> levels_{};
  std::size_t total_ = 0;
};

void check_materials(const OctreeSource& source) {
  for (std::size_t i = 0; i < source.materials.size(); ++i) {
    if (!source.transmits[i] && source.materials[i] > kOctreeMaxMaterials)
      throw Error("octree", "at most " + std::to_string(kOctreeMaxMaterials + 1) + " materials are supported",
                  "merge equal materials of the file");
  }
}

const OctreeBricks::Entry* find_entry(const OctreeBricks* bricks, std::uint32_t code) {
  if (!bricks) return nullptr;
  const auto found = bricks->bricks.find(code);
  return found == bricks->bricks.end() ? nullptr : &found->second;
}

}  // namespace

std::optional<OctreeBricks> build_octree_bricks(const OctreeSource& source, const OctreeOptions& options,
                                                const OctreeBricks* before, const OctreeProgress& progress) {
  check_materials(source);
  OctreeBricks out;
  out.grid = compute_octree_grid(source, options, before ? &before->grid : nullptr);
  if (out.grid.side_m <= 0.0) return out;
  const Builder builder(source, out.grid);
  const Bins bins = builder.bin();
  const std::size_t count = bins.begin.size() - 1;
  std::vector<OctreeBricks::Entry> entries(count);
  NodeBudget budget(options.max_nodes);
  std::mutex mutex;
  std::size_t done = 0;
  std::atomic<bool> fits = true;
  const auto cancelled = [&] { return progress.cancel && *progress.cancel; };
  parallel_for(std::size_t{0}, count, [&](std::size_t b) {
    const std::span<const Triangle> triangles(bins.triangles.data() + bins.begin[b], bins.begin[b + 1] - bins.begin[b]);
    if (cancelled() || triangles.empty() || (!fits && out.grid.detail > 0)) return;
    OctreeBricks::Entry entry;
    entry.key = builder.key(triangles);
    const OctreeBricks::Entry* old = find_entry(before, static_cast<std::uint32_t>(b));
    const bool reuse = old && old->key == entry.key;
    entry.brick = reuse ? old->brick : builder.build(static_cast<std::uint32_t>(b), triangles);
    const std::lock_guard lock(mutex);
    out.reused += reuse;
    if (!reuse && progress.finished) progress.finished(static_cast<std::uint32_t>(b), entry);
    fits = budget.add(entry.brick) && fits.load();
    if (fits) entries[b] = std::move(entry);
    done += triangles.size();
    if (progress.report) progress.report(static_cast<double>(done) / static_cast<double>(bins.triangles.size()));
  });
  if (cancelled()) return std::nullopt;
  if (!fits && out.grid.detail > 0) {
    OctreeOptions even = options;
    even.detail = 0;
    return build_octree_bricks(source, even, before, progress);
  }
  budget.check(out.grid, out.grid.depth - options.depth);
  for (std::size_t b = 0; b < count; ++b)
    if (entries[b].key != 0) out.bricks.emplace(static_cast<std::uint32_t>(b), std::move(entries[b]));
  return out;
}

struct OctreePieces::Impl {
  Builder builder;
  Bins bins;
};

OctreePieces::OctreePieces(const OctreeSource& source, const OctreeGrid& grid)
    : impl_(std::make_unique<Impl>(Impl{Builder(source, grid), {}})) {
  impl_->bins = impl_->builder.bin();
}
OctreePieces::~OctreePieces() = default;

std::vector<OctreePiece> OctreePieces::of_brick(std::uint32_t code) const {
  const Bins& bins = impl_->bins;
  std::vector<OctreePiece> pieces;
  const OctreeFragments fragments = impl_->builder.clip(
      code, std::span(bins.triangles.data() + bins.begin[code], bins.begin[code + 1] - bins.begin[code]));
  const glm::dvec3 lower(impl_->builder.brick_lower(code));
  for (const OctreeFragment& f : fragments.pieces) {
    OctreePiece piece{f.code, static_cast<int>(f.material), f.color, f.opacity, {}};
    piece.polygon.count = static_cast<int>(f.corner_count);
    for (std::uint32_t k = 0; k < f.corner_count; ++k)
      piece.polygon.corners[k] = glm::dvec3(fragments.corners[f.first_corner + k]) + lower;
    pieces.push_back(piece);
  }
  std::stable_sort(pieces.begin(), pieces.end(), [](auto& a, auto& b) { return a.code < b.code; });
  return pieces;
}

Octree build_octree(const OctreeSource& source, const OctreeOptions& options) {
  return assemble_octree(*build_octree_bricks(source, options, nullptr, {}));
}

}  // namespace maquette
