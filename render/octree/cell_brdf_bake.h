#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "render/math/local_pca.h"
#include "render/octree/cell_brdf.h"
#include "render/octree/octree_build.h"

namespace maquette {

struct CellBrdfOptions {
  int clusters = 32;
  int components = 4;   ///< fixed by the traversal's shader
  int training = 2000;  ///< cells to which the compression is fitted
  int samples = 48;     ///< points of a cell's surface
};

/// Inputs of a bake of cell BRDFs. References must outlive the call. `materials[i]` is the material of index i in
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
  float scale = 0.0f;  ///< of the light part; the area part is not scaled
  CellRotation turn;   ///< rotation of its frame
  /// Shared by all flat cells with one material and colour: baked once.
  bool shared = false;
};

/// Divides the light part by its own size, so that dark cells count as much as bright ones; returns that size over a
/// constant.
float normalise_cell_brdf(Eigen::VectorXf* vector);

struct CellBrdfs {
  LocalPca pca;  ///< fitted to normalised vectors
  struct Brick {
    std::uint64_t key = 0;             ///< hash of all inputs of its codes
    std::vector<std::uint32_t> nodes;  ///< nodes of the brick with a code, in the order of OctreeBrick::words
    std::vector<std::uint32_t> codes;  ///< [node] index in `table`
    std::vector<CellBrdfCode> table;
  };
  double fit_loss = 0.0;  ///< share of the light's energy that the compression lost on the training cells
  std::map<std::uint32_t, Brick> bricks;  ///< by Morton code; includes bricks without any code
  std::size_t reused = 0;                 ///< bricks taken from the previous bake
  std::size_t baked_cells = 0;            ///< vectors computed in this bake, without the training cells
  /// Over those vectors: squared errors of the compression and energies of the input, weighted by solid angles.
  double light_error = 0.0, light_energy = 0.0;  ///< each cell's light relative to its own
  double area_error = 0.0, area_energy = 0.0;
  std::size_t cell_count() const;    ///< nodes that have a code
  std::size_t shared_count() const;  ///< of these, nodes with a shared code
};

struct CellBrdfProgress {
  const std::atomic<bool>* cancel = nullptr;
  std::function<void(double)> report;  ///< in [0, 1], one thread at a time
  /// A new brick, one thread at a time; its compression is that of the first argument.
  std::function<void(const CellBrdfs&, std::uint32_t, const CellBrdfs::Brick&)> finished;
  std::function<void()> refit = {};  ///< everything that has been finished so far is invalid
};

/// Bakes the bricks that differ from `before`, in parallel; returns nothing when cancelled. The compression of `before`
/// is kept while it is accurate enough, so that a new material or a dent costs only the bricks that contain it. A node
/// that is not flat or has several materials gets its own BRDF; flat nodes of one material share one. Nodes with
/// emissive surfaces and nodes above the bricks get none.
std::optional<CellBrdfs> bake_cell_brdfs(const CellBrdfSource& source, const CellBrdfOptions& options,
                                         const CellBrdfs* before, const CellBrdfProgress& progress);

/// Tables of measured materials by source: make_cell_materials reads them once and keeps them here. Its result ends
/// with the default material.
using CellTables = std::map<std::string, std::shared_ptr<const BrdfTable>>;
/// CellMaterial::content of each material, without reading tables: the names of their sources are hashed instead.
std::vector<std::uint64_t> cell_material_contents(const std::vector<Material>& materials);
std::vector<CellMaterial> make_cell_materials(const std::vector<Material>& materials, CellTables* library);

/// Code of every node of an assembled octree (only its depth and levels are read): index + 1 in `table`, 0: none.
struct CellBrdfIndex {
  std::vector<std::uint32_t> codes;
  std::vector<CellBrdfCode> table;
};
CellBrdfIndex index_cell_brdfs(const CellBrdfs& brdfs, const OctreeBricks& bricks, const Octree& octree);

/// Writes a bake file (docs/formats.md, `octree_brdf.exr`).
void save_cell_brdf_file(const std::string& path, const CellBrdfs& brdfs, const std::string& scene, bool complete);
struct CellBrdfFile {
  CellBrdfs brdfs;
  bool complete = false;
};
/// Throws Error when the file is absent, damaged, inconsistent or without cell BRDFs.
CellBrdfFile load_cell_brdf_file(const std::string& path);
/// Path beside the octree's file; empty when that is empty.
std::string cell_brdf_file_path(const std::string& octree_path);

}  // namespace maquette
