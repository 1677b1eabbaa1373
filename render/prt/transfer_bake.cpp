#include "render/prt/transfer_bake.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <thread>

#include "render/bake/bake_attributes.h"
#include "render/bake/kept_bakes.h"
#include "render/prt/buried_vertices.h"
#include "render/prt/transfer_files.h"

namespace maquette {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kOccluderPoints = 256;

/// Of what casts shadows, evenly spaced in the order of the geometry.
std::vector<glm::vec3> occluder_points(const TransferJob& job) {
  std::vector<glm::vec3> all, points;
  for (std::size_t i = 0; i < job.geometry->items.size(); ++i) {
    const DrawItem& item = job.geometry->items[i];
    if (!job.occluding[i]) continue;
    all.insert(all.end(), job.geometry->positions.begin() + item.first_vertex,
               job.geometry->positions.begin() + item.first_vertex + item.vertex_count);
  }
  const std::size_t step = std::max<std::size_t>(1, (all.size() + kOccluderPoints - 1) / kOccluderPoints);
  for (std::size_t i = 0; i < all.size(); i += step) points.push_back(all[i]);
  return points;
}

std::vector<glm::vec3> positions_of(const TransferMesh& mesh) {
  std::vector<glm::vec3> positions;
  for (const TransferVertex& v : mesh.vertices) positions.push_back(v.position);
  return positions;
}

struct BlockPlace {
  std::size_t group = 0;
  int view = -1;  ///< -1: the mean
};
int components_of(const TransferJob& job, std::size_t group) {
  return std::min(job.options.btf_components, job.materials[group]->components);
}

std::vector<BlockPlace> places_of(const TransferJob& job) {
  std::vector<BlockPlace> places;
  for (std::size_t g = 0; g < job.materials.size(); ++g) {
    places.push_back({g, -1});
    if (components_of(job, g) == 0) continue;
    for (std::size_t v = 0; v < job.materials[g]->views.size(); ++v) places.push_back({g, static_cast<int>(v)});
  }
  return places;
}

std::string option_difference(const TransferProvenance& found, const TransferProvenance& wanted) {
  const auto differ = [](const char* what, int a, int b) {
    return std::string(what) + " " + std::to_string(a) + " instead of " + std::to_string(b);
  };
  if (found.faces != wanted.faces) return differ("prt.faces", found.faces, wanted.faces);
  if (found.rays != wanted.rays) return differ("prt.rays", found.rays, wanted.rays);
  if (found.clusters != wanted.clusters) return differ("prt.clusters", found.clusters, wanted.clusters);
  if (found.components != wanted.components) return differ("prt.components", found.components, wanted.components);
  if (found.btf_components != wanted.btf_components)
    return differ("prt.btf_components", found.btf_components, wanted.btf_components);
  if (found.shape != wanted.shape) return "another mesh, or other parts, of scene " + found.scene;
  if (found.materials != wanted.materials) return "other materials of scene " + found.scene;
  return {};
}

/// Whether a bake of the same shape is that of the parts as they stand now: turned along with what casts shadows.
struct Placement {
  std::optional<RigidMotion> motion;  ///< none: the vertices have moved against each other
  bool shadows_fit = true;
};
Placement place(const TransferProvenance& found, const std::vector<glm::vec3>& positions,
                const std::vector<glm::vec3>& occluders, const TransferProvenance& wanted, const TransferMesh& mesh,
                const std::vector<glm::vec3>& occluders_now) {
  Placement placement;
  if (found.geometry == wanted.geometry)
    placement.motion = RigidMotion{};
  else
    placement.motion = find_rigid_motion(positions, positions_of(mesh));
  if (!placement.motion) return placement;
  if (found.geometry == wanted.geometry && found.occluders == wanted.occluders) return placement;
  placement.shadows_fit = occluders.size() == occluders_now.size();
  double size = 0.0;
  for (const glm::vec3& p : occluders_now) size = std::max(size, static_cast<double>(glm::length(p)));
  for (std::size_t i = 0; i < occluders.size() && placement.shadows_fit; ++i)
    placement.shadows_fit = glm::length(placement.motion->rotation * glm::dvec3(occluders[i]) +
                                        placement.motion->shift - glm::dvec3(occluders_now[i])) <= 1e-5 * size;
  return placement;
}

constexpr const char* kStaleShadows = "what casts shadows did not turn along with its parts";

/// One bake under way.
class Run {
 public:
  Run(const TransferJob& job, const BakeRanks& ranks, const std::atomic<bool>& cancel,
      const std::function<void(double)>& progress)
      : job_(job),
        ranks_(ranks),
        cancel_(cancel),
        progress_(progress),
        cube_(job.options.faces),
        places_(places_of(job)),
        bake_(std::make_shared<TransferBake>()),
        blocks_(places_.size()) {}

  std::shared_ptr<const Transfer> make(const std::shared_ptr<const TransferBake>& last) {
    auto transfer = std::make_shared<Transfer>();
    transfer->mesh = make_transfer_mesh(*job_.geometry, job_.parts, job_.options.vertices);
    occluders_ = occluder_points(job_);
    wanted_ = provenance_of(job_, transfer->mesh);
    if (last && option_difference(last->provenance, wanted_).empty()) {
      const Placement at =
          place(last->provenance, last->positions, last->occluders, wanted_, transfer->mesh, occluders_);
      if (at.motion && at.shadows_fit) {
        transfer->bake = last;
        transfer->baked_from_world = glm::transpose(at.motion->rotation);
        return transfer;
      }
    }
    check_manifest(transfer.get());
    load_blocks();
    if (!job_.may_make && done_ < blocks_.size()) fail_incomplete();
    if (!make_blocks(transfer->mesh) || !await_others()) return nullptr;
    assemble(transfer->mesh);
    transfer->bake = bake_;
    if (progress_) progress_(1.0);
    return transfer;
  }

 private:
  void check_manifest(Transfer* transfer) {
    bake_->provenance = wanted_;
    bake_->positions = positions_of(transfer->mesh);
    bake_->occluders = occluders_;
    if (job_.folder.empty()) return;
    const std::string path = transfer_manifest_path(job_.folder);
    std::error_code ignored;
    if (!fs::exists(path, ignored)) {
      if (!job_.may_make) throw Error(job_.folder, "there is no radiance transfer", "make it: maquette bake prt");
      if (ranks_.rank == 0) write_manifest(path);
      return;
    }
    TransferManifest found;
    try {
      found = load_transfer_manifest(path);
    } catch (const Error&) {
      if (!job_.may_make) throw;
      return write_manifest(path);
    }
    if (const std::string other = option_difference(found.provenance, wanted_); !other.empty())
      throw Error(job_.folder, "the radiance transfer was baked with " + other,
                  "name another folder, or remove it and bake again");
    const Placement at = place(found.provenance, found.positions, found.occluders, wanted_, transfer->mesh, occluders_);
    if (!at.motion)
      throw Error(job_.folder, "the radiance transfer is stale: the vertices of its parts have moved",
                  "name another folder, or remove it and bake again");
    if (!at.shadows_fit) {
      transfer->stale = kStaleShadows;
      if (job_.may_make || !job_.show_stale)
        throw Error(job_.folder, std::string("the radiance transfer is stale: ") + kStaleShadows,
                    job_.may_make ? "name another folder, or remove it and bake again"
                                  : "bake it again, with prt.shadows=parts to let it turn alone, or show it: --set "
                                    "prt.stale=show");
    }
    transfer->baked_from_world = glm::transpose(at.motion->rotation);
    bake_->provenance = found.provenance;
    bake_->positions = std::move(found.positions);
    bake_->occluders = std::move(found.occluders);
  }

  void write_manifest(const std::string& path) const {
    try {
      std::error_code ignored;
      fs::create_directories(job_.folder, ignored);
      save_transfer_manifest(path, {bake_->provenance, bake_->positions, bake_->occluders, places_.size()});
    } catch (const Error&) {
      if (job_.must_work) throw;
    }
  }

  void load_blocks() {
    if (job_.folder.empty()) return;
    for (std::size_t b = 0; b < blocks_.size() && !cancel_; ++b) bake_->reused += load_block(b) ? 1 : 0;
  }

  /// False where there is none. One that is damaged counts as none where it can be made again.
  bool load_block(std::size_t b) {
    const std::string path = transfer_block_path(job_.folder, b);
    std::error_code ignored;
    if (!fs::exists(path, ignored)) return false;
    try {
      TransferBlock block =
          load_transfer_block(path, transfer_key(bake_->provenance), static_cast<std::size_t>(cube_.count()));
      if (block.size() != matrices_of(b)) throw Error(path, "the block has another count of matrices", "bake it again");
      blocks_[b] = std::move(block);
    } catch (const Error&) {
      if (!job_.may_make) throw;
      return false;
    }
    ++done_;
    report();
    return true;
  }

  std::size_t matrices_of(std::size_t b) const {
    return places_[b].view < 0 ? 1 : static_cast<std::size_t>(components_of(job_, places_[b].group));
  }

  bool make_blocks(const TransferMesh& mesh) {
    if (done_ == blocks_.size()) return !cancel_;
    ArrivingLight arriving;
    std::unique_ptr<LightTable> table;
    std::size_t group_of_table = job_.materials.size();
    const std::vector<std::vector<std::uint32_t>> vertices = vertices_of_groups(mesh, job_.materials.size());
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      if (!blocks_[b].empty() || !ranks_.has(b)) continue;
      if (cancel_) return false;
      if (arriving.first.empty()) {
        arriving = trace_light(mesh);
        if (cancel_) return false;
      }
      const auto [group, view] = places_[b];
      const Btf& material = *job_.materials[group];
      const auto& lights = material.views[static_cast<std::size_t>(std::max(view, 0))].lights;
      if (group_of_table != group || table->lights() != lights)
        table = std::make_unique<LightTable>(arriving, vertices[group], lights);
      group_of_table = group;
      TransferBlock block = make_block(*table, material, b, vertices[group].empty());
      if (cancel_) return false;
      save_block(b, block);
      blocks_[b] = std::move(block);
      ++done_;
      report();
    }
    return true;
  }

  ArrivingLight trace_light(const TransferMesh& mesh) const {
    const RayScene scene = build_ray_scene(*job_.geometry, job_.occluding);
    ArrivingLight light = trace_arriving_light(mesh, cube_, scene, {job_.options.rays}, cancel_);
    if (!cancel_) light_buried_vertices(mesh, find_buried_vertices(mesh, *job_.geometry, cube_, scene, light), &light);
    return light;
  }

  TransferBlock make_block(const LightTable& table, const Btf& material, std::size_t b, bool empty) const {
    TransferBlock block;
    const int view = places_[b].view;
    const TransferPcaOptions options{job_.options.clusters, job_.options.components, [this] { return cancel_.load(); }};
    for (std::size_t c = 0; c < matrices_of(b); ++c) {
      const auto weights =
          view < 0 ? std::vector<float>() : material.views[static_cast<std::size_t>(view)].light_weights;
      Eigen::MatrixXf transfer = table.transfer(cube_.count(), weights, material.components, static_cast<int>(c));
      if (empty) transfer = Eigen::MatrixXf::Zero(cube_.count(), 1);
      block.push_back(factorise_transfer(transfer, cube_, options));
      if (empty) block.back().owner.clear(), block.back().weights.clear(), block.back().squares.clear();
    }
    return block;
  }

  void save_block(std::size_t b, const TransferBlock& block) const {
    if (job_.folder.empty()) return;
    try {
      std::error_code ignored;
      fs::create_directories(job_.folder, ignored);
      save_transfer_block(transfer_block_path(job_.folder, b), transfer_key(bake_->provenance), block);
    } catch (const Error&) {
      if (job_.must_work) throw;
    }
  }

  bool await_others() {
    while (done_ < blocks_.size()) {
      if (cancel_) return false;
      bool any = false;
      for (std::size_t b = 0; b < blocks_.size(); ++b)
        if (blocks_[b].empty()) any |= load_block(b);
      if (!any) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return true;
  }

  /// Stacks the light sides of all blocks, in their order, whoever made them.
  void assemble(const TransferMesh& mesh) {
    bake_->options = job_.options;
    bake_->blocks = blocks_.size();
    std::vector<std::vector<std::uint32_t>> vertices = vertices_of_groups(mesh, job_.materials.size());
    std::size_t rows = 0;
    for (const TransferBlock& block : blocks_)
      for (const TransferMatrix& matrix : block) rows += matrix.rows();
    bake_->table = RelightTable(job_.options.faces, rows);
    bake_->groups.resize(job_.materials.size());
    double squares = 0.0;
    std::size_t count = 0;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      TransferGroup& group = bake_->groups[places_[b].group];
      if (places_[b].view < 0) {
        group.material = job_.materials[places_[b].group];
        group.components = components_of(job_, places_[b].group);
        group.vertices = std::move(vertices[places_[b].group]);
      }
      for (TransferMatrix& matrix : blocks_[b]) {
        group.rows.push_back(bake_->table.add(matrix));
        squares += matrix.error * matrix.error;
        ++count;
        matrix.q = {};
        group.matrices.push_back(std::move(matrix));
      }
    }
    for (TransferGroup& group : bake_->groups) sum_errors(&group);
    bake_->error = count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 0.0;
  }

  static void sum_errors(TransferGroup* group) {
    std::vector<double> squares(group->vertices.size(), 0.0);
    double energy = 0.0;
    for (TransferMatrix& matrix : group->matrices) {
      energy += matrix.energy;
      for (std::size_t i = 0; i < squares.size(); ++i) squares[i] += static_cast<double>(matrix.squares[i]);
      matrix.squares = {};
    }
    for (const double s : squares)
      group->errors.push_back(static_cast<float>(energy > 0.0 ? std::sqrt(s / energy) : 0.0));
  }

  [[noreturn]] void fail_incomplete() const {
    throw Error(job_.folder,
                "the radiance transfer is not complete: " + std::to_string(done_) + " of " +
                    std::to_string(blocks_.size()) + " blocks",
                "finish it: maquette bake prt");
  }
  void report() const {
    if (progress_) progress_(static_cast<double>(done_) / static_cast<double>(blocks_.size()));
  }

  const TransferJob& job_;
  const BakeRanks ranks_;
  const std::atomic<bool>& cancel_;
  const std::function<void(double)>& progress_;
  CubeDirections cube_;
  std::vector<BlockPlace> places_;
  std::shared_ptr<TransferBake> bake_;
  TransferProvenance wanted_;
  std::vector<glm::vec3> occluders_;
  std::vector<TransferBlock> blocks_;
  std::size_t done_ = 0;
};

}  // namespace

std::size_t TransferBake::bytes_per_vertex(const TransferGroup& group) const {
  return group.matrices.size() * static_cast<std::size_t>(1 + options.components) * sizeof(std::uint16_t);
}

TransferProvenance provenance_of(const TransferJob& job, const TransferMesh& mesh) {
  TransferProvenance p;
  p.scene = job.scene;
  std::vector<std::uint64_t> shape{mesh.vertices.size(), mesh.triangles.size()};
  for (const TransferPart& part : mesh.parts) shape.push_back(part.group);
  for (const auto& t : mesh.triangles) shape.push_back(static_cast<std::uint64_t>(t.level));
  p.shape = chain_hash(mesh.grid, chain_hash(shape, 0));
  std::vector<float> frames;
  for (const TransferVertex& v : mesh.vertices)
    for (const glm::vec3& x : {v.position, v.n, v.t, v.b}) frames.insert(frames.end(), {x.x, x.y, x.z});
  p.geometry = chain_hash(frames, p.shape);
  std::vector<std::uint32_t> corners;
  std::vector<glm::vec3> occluders;
  for (std::size_t i = 0; i < job.geometry->items.size(); ++i) {
    const DrawItem& item = job.geometry->items[i];
    if (!job.occluding[i]) continue;
    for (std::uint32_t k = 0; k < item.index_count; ++k)
      corners.push_back(job.geometry->indices[item.first_index + k] - item.first_vertex);
    occluders.insert(occluders.end(), job.geometry->positions.begin() + item.first_vertex,
                     job.geometry->positions.begin() + item.first_vertex + item.vertex_count);
  }
  p.occluders = chain_hash(occluders, chain_hash(corners, 0));
  std::vector<std::uint64_t> materials;
  for (const auto& material : job.materials) materials.push_back(material->hash);
  p.materials = chain_hash(materials, 0);
  p.faces = job.options.faces;
  p.rays = job.options.rays;
  p.clusters = job.options.clusters;
  p.components = job.options.components;
  p.btf_components = job.options.btf_components;
  return p;
}

std::string transfer_folder(const std::string& folder, const TransferJob& job, const TransferMesh& mesh) {
  if (!folder.empty()) return (fs::path(folder) / (bake_name_of_scene(job.scene) + "-prt")).string();
  const auto cache = cache_folder();
  if (!cache) return {};
  return (*cache / ("prt-" + transfer_key(provenance_of(job, mesh)))).string();
}

std::shared_ptr<const Transfer> bake_transfer(const TransferJob& job, const BakeRanks& ranks,
                                              const std::shared_ptr<const TransferBake>& last,
                                              const std::atomic<bool>& cancel,
                                              const std::function<void(double)>& progress) {
  return Run(job, ranks, cancel, progress).make(last);
}

TransferSummary summarize_transfer(const std::string& folder) {
  const TransferManifest manifest = load_transfer_manifest(transfer_manifest_path(folder));
  TransferSummary summary{manifest.provenance, manifest.positions.size(), manifest.blocks, 0};
  std::error_code ignored;
  for (std::size_t b = 0; b < summary.blocks; ++b)
    summary.blocks_done += fs::exists(transfer_block_path(folder, b), ignored) ? 1 : 0;
  return summary;
}

}  // namespace maquette
