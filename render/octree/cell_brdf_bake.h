#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "render/local_pca.h"
#include "render/octree/cell_brdf.h"
#include "render/octree/octree_build.h"

namespace maquette {

struct CellBrdfOptions {
  int clusters = 32;
  int components = 4;   ///< the walk's shader knows no other number
  int training = 2000;  ///< cells that the compression is fitted on
  int samples = 48;     ///< points of a cell's surface
};

/// What cell BRDFs are baked from. References must outlive the call. `materials[i]` is the material of index i in
/// `source.materials`.
struct CellBrdfSource {
  const OctreeSource& source;
  const OctreeBricks& bricks;
  const std::vector<CellMaterial>& materials;
};

/// A compressed BRDF.
struct CellBrdfCode {
  std::uint32_t cluster = 0;
  std::array<float, 4> weights{};
  float scale = 0.0f;  ///< of the part that is light; areas have none
  CellTurn turn;       ///< of the frame that all of it is in
  /// Of all flat cells with one material and colour: baked once.
  bool shared = false;
};

/// Light divided by its own size, so that dark cells count as much as bright ones; gives that size over a constant.
float normalise_cell_brdf(Eigen::VectorXf* vector);

struct CellBrdfs {
  LocalPca pca;  ///< of such vectors
  struct Brick {
    std::uint64_t key = 0;             ///< hash of all that its codes were made from
    std::vector<std::uint32_t> nodes;  ///< of the brick, in the order of OctreeBrick::words
    std::vector<std::uint32_t> codes;  ///< of each of those, index in `table`
    std::vector<CellBrdfCode> table;
  };
  double fit_loss = 0.0;  ///< share of the light's energy that the compression lost of what it was fitted on
  std::map<std::uint32_t, Brick> bricks;  ///< by Morton code; those without any code too
  std::size_t reused = 0;                 ///< bricks that came from the bake before
  std::size_t baked_cells = 0;            ///< vectors computed just now, those of the fit apart
  /// Of those: sums of squared differences by the compression, and of what was compressed, by solid angles.
  double light_error = 0.0, light_energy = 0.0;  ///< each cell's light relative to its own
  double area_error = 0.0, area_energy = 0.0;
  std::size_t cell_count() const;    ///< nodes that have a code
  std::size_t shared_count() const;  ///< of them, with a shared one
};

struct CellBrdfProgress {
  const std::atomic<bool>* cancel = nullptr;
  std::function<void(double)> report;  ///< in [0, 1], one thread at a time
  /// A new brick, one thread at a time; the compression is that of the first argument.
  std::function<void(const CellBrdfs&, std::uint32_t, const CellBrdfs::Brick&)> finished;
  std::function<void()> refit = {};  ///< what has been finished so far is void
};

/// Bakes what differs from `before` on all cores; nothing when cancelled. The compression of `before` is kept
/// while it serves, so that a new paint or a dent costs only the bricks it is in. A node of several materials, or not
/// flat, gets a BRDF of its own, flat ones of one material share; nodes that hold something that glows get none, nor
/// those above the bricks.
std::optional<CellBrdfs> bake_cell_brdfs(const CellBrdfSource& source, const CellBrdfOptions& options,
                                         const CellBrdfs* before, const CellBrdfProgress& progress);

/// Materials of a scene for their cells, the default one last; tables are read and kept in `library` (by source).
using CellTables = std::map<std::string, std::shared_ptr<const BrdfTable>>;
/// CellMaterial::content of each, without reading tables: their sources stand for them.
std::vector<std::uint64_t> cell_material_contents(const std::vector<Material>& materials);
std::vector<CellMaterial> make_cell_materials(const std::vector<Material>& materials, CellTables* library);

/// Code of every node of an assembled octree (of which only depth and levels are read): index + 1 in `table`, 0: none.
struct CellBrdfIndex {
  std::vector<std::uint32_t> codes;
  std::vector<CellBrdfCode> table;
};
CellBrdfIndex index_cell_brdfs(const CellBrdfs& brdfs, const OctreeBricks& bricks, const Octree& octree);

/// As a bake file (docs/formats.md, `octree_brdf.exr`).
void save_cell_brdf_file(const std::string& path, const CellBrdfs& brdfs, const std::string& scene, bool complete);
struct CellBrdfFile {
  CellBrdfs brdfs;
  bool complete = false;
};
/// Throws Error: absent, damaged, no cell BRDFs, or inconsistent.
CellBrdfFile load_cell_brdf_file(const std::string& path);
/// Beside the octree's file; empty when that is.
std::string cell_brdf_file_path(const std::string& octree_path);

}  // namespace maquette
