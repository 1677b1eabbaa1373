#pragma once

#include <atomic>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/bake/bake_ranks.h"
#include "render/prt/factorised_transfer.h"
#include "render/prt/joint_btf.h"
#include "render/prt/relight.h"
#include "render/prt/transfer.h"
#include "render/prt/vertex_density.h"

namespace maquette {

struct TransferOptions {
  int faces = 16;          ///< side of a face of the light's cube
  int rays = 2;            ///< a side of the points of its texels
  int clusters = 32;       ///< of each view and component
  int components = 6;      ///< of the transfer
  int btf_components = 8;  ///< of the materials, at most
  double btf_error = 0.0;  ///< of a material, that decides how many: MaterialFit; 0: all that btf_components allows
  int bounces = 0;         ///< reflections between parts; from 1 on transfer is by colour
  /// All views in one factorisation of material and of transfer, instead of one for each view.
  bool joint = false;
  int texel_clusters = 8;    ///< of the material, in the joint form
  int joint_clusters = 8;    ///< of vertices, for each function of the material, in the joint form
  std::size_t vertices = 0;  ///< at least so many; 0: those drawn
  bool parts_alone = false;  ///< only the parts cast shadows, and not the rest of the scene
};
inline constexpr int kMostTransferClusters = 256, kMostTransferComponents = 16;

/// All that transfer is computed from, by value.
struct TransferJob {
  std::string scene;  ///< its name, for messages and folders
  std::shared_ptr<const FlatGeometry> geometry;
  std::vector<TransferPart> parts;
  std::vector<VertexDensity> densities;               ///< [part], where its division was chosen by an error
  std::vector<std::shared_ptr<const Btf>> materials;  ///< [group]
  std::vector<bool> occluding;                        ///< [item]
  std::vector<std::string> left_out;                  ///< what transfer does not hold, a line each
  TransferOptions options;
  std::string key;          ///< of all that the bake depends on, before materials are factorised: transfer_key
  std::string folder;       ///< of the bake's files; empty: it is kept in memory only
  bool must_work = false;   ///< the folder was named by the user: what is damaged or cannot be written is an error
  bool may_make = true;     ///< false: only what the folder holds is taken, and it must be whole
  bool show_stale = false;  ///< with `may_make` false: also where what casts shadows did not turn along
  /// May be empty. Called once where blocks are missing, as soon as the means of all materials are there: transfer
  /// without components, to be shown until the rest is made.
  std::function<void(const struct Transfer&)> preview;
};

/// A material as its transfer is computed.
struct MaterialFit {
  int components = 0;  ///< the fewest whose error is at most TransferOptions::btf_error, or what its limit allows
  /// RMS of what is left away over views, texels and the lights of reflect_broad_lights, relative to what the material
  /// reflects.
  double error = 0.0;
  double error_of_mean = 0.0;             ///< the same without any component
  std::shared_ptr<const JointBtf> joint;  ///< in the joint form
};
/// How many components a material gets, and with which error. Nothing once cancelled.
std::optional<MaterialFit> fit_material(const Btf& material, const TransferOptions& options,
                                        const std::atomic<bool>& cancel);

/// What a bake was made of: written into its files, and compared with what is asked for.
struct TransferProvenance {
  std::string scene;
  std::uint64_t geometry = 0;   ///< hash of vertices and triangles
  std::uint64_t occluders = 0;  ///< hash of what casts shadows
  std::uint64_t materials = 0;  ///< hash of the factorised materials
  std::uint64_t shape = 0;      ///< hash of what a rigid motion leaves as it is
  int faces = 0, rays = 0, clusters = 0, components = 0, btf_components = 0, bounces = 0;
  int texel_clusters = 0;  ///< 0: the form by views
  double btf_error = 0.0;
  /// Hash of the joint factorisations of the materials, whose functions the blocks are transfer of; 0: the form by
  /// views, or not computed yet.
  std::uint64_t fit = 0;
  bool operator==(const TransferProvenance&) const = default;
};

/// Transfer of one material's vertices.
struct TransferGroup {
  std::shared_ptr<const Btf> material;
  MaterialFit fit;
  std::vector<std::uint32_t> vertices;
  /// First that of the mean, which is the same for all views, then [view][component]. Their q is in the table. In the
  /// joint form [function][view]; those of a function's first view hold clusters and weights of all its views.
  std::vector<TransferMatrix> matrices;
  std::vector<std::size_t> rows;  ///< [matrix] first row in TransferBake::table
  std::vector<float> errors;      ///< [vertex] RMS of compression over all matrices, relative to the group's transfer
  std::size_t matrix_of(std::size_t view, int component) const {
    return 1 + view * static_cast<std::size_t>(fit.components) + static_cast<std::size_t>(component);
  }
};

/// What was baked, in the frame that the parts had then.
struct TransferBake {
  TransferOptions options;
  std::vector<TransferGroup> groups;
  RelightTable table;
  TransferProvenance provenance;
  std::vector<glm::vec3> positions;    ///< of the vertices, m
  std::vector<glm::vec3> occluders;    ///< some points of what casts shadows, m
  std::size_t reused = 0, blocks = 0;  ///< blocks that an earlier run had made, and all
  double compression = 0.0;            ///< RMS of compression relative to the RMS of the transfer, over all matrices
  double materials = 0.0;              ///< RMS of MaterialFit::error over the vertices
  double error() const { return std::hypot(compression, materials); }  ///< of all that was factorised
  double bounce_seconds = 0.0;   ///< time that reflections took, beside that of larger matrices; 0: none, or loaded
  std::size_t bounce_bytes = 0;  ///< memory that they took
  /// Bytes of weights and clusters that a vertex of a group takes.
  std::size_t bytes_per_vertex(const TransferGroup& group) const;
};

/// A bake and the parts that it is shown on.
struct Transfer {
  TransferMesh mesh;
  std::shared_ptr<const TransferBake> bake;
  glm::dmat3 baked_from_world{1.0};   ///< rotation: the parts may have been turned since
  std::string stale;                  ///< what has changed; empty: nothing
  std::vector<std::string> left_out;  ///< TransferJob::left_out
  std::string key;                    ///< TransferJob::key
};

TransferProvenance provenance_of(const TransferJob& job, const TransferMesh& mesh);
/// Where the bake of a scene is kept: below `folder`, or, where that is empty, in the cache by `key`. Empty without
/// either.
std::string transfer_folder(const std::string& folder, const std::string& scene, const std::string& key);

/// Loads the blocks that the folder holds (a block: one view of one material), makes the others and writes each when it
/// is done. One block's matrices are in memory in full at a time. Null once `cancel` is set. Throws Error: a bake of
/// another mesh, material or setting, damaged files or a full disk where `must_work`; what was written stays. The same
/// for any count of threads, ranks and interruptions.
/// `last`: a bake that is in memory; it is shown again where only a rigid motion lies between. May be null.
std::shared_ptr<const Transfer> bake_transfer(const TransferJob& job, const BakeRanks& ranks,
                                              const std::shared_ptr<const TransferBake>& last,
                                              const std::atomic<bool>& cancel,
                                              const std::function<void(double)>& progress);

/// The rotation and shift that take `from` to `to`, if there is one within `tolerance` (of the size of `from`).
/// Source: Horn, Hilden and Negahdaripour 1988, "Closed-form solution of absolute orientation using orthonormal
/// matrices" (by the singular values of the covariance).
struct RigidMotion {
  glm::dmat3 rotation{1.0};
  glm::dvec3 shift{0.0};
};
std::optional<RigidMotion> find_rigid_motion(const std::vector<glm::vec3>& from, const std::vector<glm::vec3>& to,
                                             double tolerance = 1e-5);

/// What a folder holds, for `inspect`. Throws Error.
struct TransferSummary {
  TransferProvenance provenance;
  std::size_t vertices = 0, blocks = 0, blocks_done = 0;
};
TransferSummary summarize_transfer(const std::string& folder);
/// Whether a folder holds all of a bake.
bool is_whole_transfer(const std::string& folder);

}  // namespace maquette
