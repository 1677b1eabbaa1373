#include "render/prt/transfer_bake.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <thread>

#include "render/bake/bake_attributes.h"
#include "render/bake/kept_bakes.h"
#include "render/prt/bounces.h"
#include "render/prt/buried_vertices.h"
#include "render/prt/joint_transfer.h"
#include "render/prt/transfer_files.h"
#include "render/prt/transfer_place.h"

namespace maquette {

namespace {

namespace fs = std::filesystem;

struct BlockPlace {
  std::size_t group = 0;
  int view = -1;  ///< -1: the mean; in the joint form a function of the material
};
using MaterialFits = std::vector<MaterialFit>;  ///< [group]

std::uint64_t hash_of_fits(const MaterialFits& fits) {
  std::uint64_t hash = 0;
  for (const MaterialFit& fit : fits) {
    if (!fit.joint) continue;
    for (const std::vector<float>& functions : fit.joint->functions) hash = chain_hash(functions, hash);
    hash = chain_hash(fit.joint->texels, hash);
  }
  return hash;
}

std::vector<BlockPlace> places_of(const TransferJob& job, const MaterialFits& fits) {
  std::vector<BlockPlace> places;
  for (std::size_t g = 0; g < fits.size(); ++g) {
    if (fits[g].joint) {
      for (std::size_t f = 0; f < fits[g].joint->function_count(); ++f) places.push_back({g, static_cast<int>(f)});
      continue;
    }
    places.push_back({g, -1});
    if (fits[g].components == 0) continue;
    for (std::size_t v = 0; v < job.materials[g]->views.size(); ++v) places.push_back({g, static_cast<int>(v)});
  }
  return places;
}

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
        bake_(std::make_shared<TransferBake>()),
        patience_(ranks) {}

  std::shared_ptr<const Transfer> make(const std::shared_ptr<const TransferBake>& last) {
    auto transfer = std::make_shared<Transfer>();
    transfer->key = job_.key;
    transfer->left_out = job_.left_out;
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
    if (!fit_materials()) return nullptr;
    wanted_.fit = hash_of_fits(fits_);
    places_ = places_of(job_, fits_);
    blocks_.resize(places_.size());
    check_manifest(transfer.get());
    baked_from_world_ = transfer->baked_from_world;
    load_blocks();
    if (!job_.may_make && done_ < blocks_.size()) fail_incomplete();
    if (!make_blocks(transfer->mesh, false) || !await_others(transfer->mesh)) return nullptr;
    assemble(job_, fits_, transfer->mesh, std::move(blocks_), bake_.get());
    transfer->bake = bake_;
    if (progress_) progress_(1.0);
    return transfer;
  }

 private:
  bool fit_materials() {
    for (const auto& material : job_.materials) {
      std::optional<MaterialFit> fit = fit_material(*material, job_.options, cancel_);
      if (!fit) return false;
      fits_.push_back(std::move(*fit));
    }
    return true;
  }

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
    // The cache's name does not tell factorisations: its blocks are made again.
    if (found.provenance.fit != wanted_.fit && !job_.must_work) return write_manifest(path);
    if (const std::string other = option_difference(found.provenance, wanted_); !other.empty())
      throw Error(job_.folder, "the radiance transfer was baked with " + other,
                  "name another folder, or remove it and bake again");
    const Placement at = place(found.provenance, found.positions, found.occluders, wanted_, transfer->mesh, occluders_);
    if (!at.motion)
      throw Error(job_.folder, "the radiance transfer is stale: the vertices of its parts have moved",
                  "name another folder, or remove it and bake again");
    if (!at.shadows_fit) {
      transfer->stale = at.why;
      if (job_.may_make || !job_.show_stale)
        throw Error(job_.folder, "the radiance transfer is stale: " + at.why,
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
      for (const TransferMatrix& m : block)
        if (m.channels != (job_.options.bounces > 0 ? 3 : 1))
          throw Error(path, "the block has another count of colours", "bake it again");
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
    if (job_.options.joint) return job_.materials[places_[b].group]->views.size();
    return places_[b].view < 0 ? 1 : static_cast<std::size_t>(fits_[places_[b].group].components);
  }

  /// Those of this process, or `all` that are missing.
  bool make_blocks(const TransferMesh& mesh, bool all) {
    if (done_ == blocks_.size()) return !cancel_;
    ArrivingLight arriving;
    std::unique_ptr<LightTable> table;
    std::size_t group_of_table = job_.materials.size();
    const std::vector<std::vector<std::uint32_t>> vertices = vertices_of_groups(mesh, job_.materials.size());
    bool shown = !job_.preview || job_.options.joint;
    for (const std::size_t b : means_first()) {
      if (!shown && places_[b].view >= 0) {
        shown = true;
        show_means(mesh);
      }
      if (!blocks_[b].empty() || (all ? load_block(b) : !ranks_.has(b))) continue;
      if (cancel_) return false;
      const auto begin = RankPatience::Clock::now();
      if (arriving.first.empty()) {
        arriving = trace_light(mesh);
        if (cancel_) return false;
      }
      const std::size_t group = places_[b].group;
      const int view = places_[b].view;
      const Btf& material = *job_.materials[group];
      const auto table_of = [&](std::size_t v) -> const LightTable& {
        const auto& lights = material.views[v].lights;
        if (group_of_table != group || table->lights() != lights)
          table = std::make_unique<LightTable>(arriving, vertices[group], lights);
        group_of_table = group;
        return *table;
      };
      TransferBlock block = job_.options.joint ? make_joint_block(table_of, b, vertices[group])
                                               : make_block(table_of(static_cast<std::size_t>(std::max(view, 0))),
                                                            material, b, vertices[group]);
      if (cancel_) return false;
      save_block(b, block);
      blocks_[b] = std::move(block);
      ++done_;
      patience_.made_block(begin);
      report();
    }
    return true;
  }

  ArrivingLight trace_light(const TransferMesh& mesh) {
    const RayScene scene = build_ray_scene(*job_.geometry, job_.occluding);
    ArrivingLight light = trace_arriving_light(mesh, cube_, scene, {job_.options.rays}, cancel_);
    if (cancel_) return light;
    const std::vector<std::uint32_t> sources =
        light_sources(mesh, find_buried_vertices(mesh, *job_.geometry, cube_, scene, light), light);
    take_light_of(sources, &light);
    if (job_.options.bounces == 0) return light;
    const auto begin = std::chrono::steady_clock::now();
    bounces_ = compute_bounces({mesh, *job_.geometry, scene, cube_, light, job_.materials, sources},
                               job_.options.bounces, cancel_);
    bake_->bounce_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    bake_->bounce_bytes = static_cast<std::size_t>(bounces_.sent.size()) * sizeof(float) +
                          bounces_.gathered.entries.size() * sizeof(GatheredLight::Entry);
    return light;
  }

  TransferBlock make_block(const LightTable& table, const Btf& material, std::size_t b,
                           const std::vector<std::uint32_t>& vertices) const {
    const bool empty = vertices.empty();
    TransferBlock block;
    const int view = places_[b].view;
    const TransferPcaOptions options{job_.options.clusters, job_.options.components, [this] { return cancel_.load(); }};
    for (std::size_t c = 0; c < matrices_of(b); ++c) {
      const auto weights =
          view < 0 ? std::vector<float>() : material.views[static_cast<std::size_t>(view)].light_weights;
      Eigen::MatrixXf transfer = table.transfer(cube_.count(), weights, material.components, static_cast<int>(c));
      if (job_.options.bounces > 0)
        transfer = add_bounces(transfer, bounces_, *table.lights(), vertices, weights, material.components,
                               static_cast<int>(c));
      if (empty) transfer = Eigen::MatrixXf::Zero(transfer.rows(), 1);
      block.push_back(factorise_transfer(transfer, cube_, options));
      if (empty) block.back().owner.clear(), block.back().weights.clear(), block.back().squares.clear();
    }
    return block;
  }

  TransferBlock make_joint_block(const std::function<const LightTable&(std::size_t)>& table, std::size_t b,
                                 const std::vector<std::uint32_t>& vertices) const {
    const JointBtf& joint = *fits_[places_[b].group].joint;
    const int function = places_[b].view, stride = static_cast<int>(joint.function_count());
    const auto of_view = [&](std::size_t v) {
      const LightTable& lights = table(v);
      Eigen::MatrixXf transfer = lights.transfer(cube_.count(), joint.functions[v], stride, function);
      if (job_.options.bounces > 0)
        transfer = add_bounces(transfer, bounces_, *lights.lights(), vertices, joint.functions[v], stride, function);
      return vertices.empty() ? Eigen::MatrixXf(Eigen::MatrixXf::Zero(transfer.rows(), 1)) : transfer;
    };
    TransferBlock block = factorise_joint_transfer(
        of_view, joint.functions.size(), cube_,
        {job_.options.joint_clusters, job_.options.components, [this] { return cancel_.load(); }});
    for (TransferMatrix& matrix : block)
      if (vertices.empty()) matrix.owner.clear(), matrix.weights.clear(), matrix.squares.clear();
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

  std::vector<std::size_t> means_first() const {
    std::vector<std::size_t> order;
    for (const bool means : {true, false})
      for (std::size_t b = 0; b < places_.size(); ++b)
        if ((places_[b].view < 0) == means) order.push_back(b);
    return order;
  }

  void show_means(const TransferMesh& mesh) const {
    std::vector<TransferBlock> means;
    for (std::size_t b = 0; b < blocks_.size(); ++b)
      if (places_[b].view < 0) means.push_back(blocks_[b]);
    for (const TransferBlock& block : means)
      if (block.empty()) return;  // another process makes it
    Transfer transfer;
    transfer.key = job_.key;
    transfer.left_out = job_.left_out;
    transfer.mesh = mesh;
    transfer.baked_from_world = baked_from_world_;
    MaterialFits of_means = fits_;
    for (MaterialFit& fit : of_means) fit.components = 0, fit.error = fit.error_of_mean;
    auto bake = std::make_shared<TransferBake>();
    bake->positions = bake_->positions;
    bake->occluders = bake_->occluders;
    assemble(job_, of_means, mesh, std::move(means), bake.get());
    transfer.bake = std::move(bake);
    job_.preview(transfer);
  }

  bool await_others(const TransferMesh& mesh) {
    patience_.begin(blocks_.size() - done_);
    while (done_ < blocks_.size()) {
      if (cancel_) return false;
      bool any = false;
      for (std::size_t b = 0; b < blocks_.size(); ++b)
        if (blocks_[b].empty()) any |= load_block(b);
      if (any)
        patience_.block_came();
      else if (patience_.is_over())
        return make_blocks(mesh, true);
      else
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return true;
  }

  /// Stacks the light sides of all blocks, in their order, whoever made them.
  static void assemble(const TransferJob& job, const MaterialFits& fits, const TransferMesh& mesh,
                       std::vector<TransferBlock> blocks, TransferBake* bake) {
    const std::vector<BlockPlace> places = places_of(job, fits);
    bake->options = job.options;
    bake->blocks = blocks.size();
    std::vector<std::vector<std::uint32_t>> vertices = vertices_of_groups(mesh, job.materials.size());
    std::size_t rows = 0;
    for (const TransferBlock& block : blocks)
      for (const TransferMatrix& matrix : block) rows += matrix.rows();
    bake->table = RelightTable(job.options.faces, rows, job.options.bounces > 0 ? 3 : 1);
    bake->groups.resize(job.materials.size());
    double squares = 0.0;
    std::size_t count = 0;
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      TransferGroup& group = bake->groups[places[b].group];
      if (!group.material) {
        group.material = job.materials[places[b].group];
        group.fit = fits[places[b].group];
        group.vertices = std::move(vertices[places[b].group]);
      }
      for (TransferMatrix& matrix : blocks[b]) {
        group.rows.push_back(bake->table.add(matrix));
        squares += matrix.error * matrix.error;
        ++count;
        matrix.q = {};
        if (job.options.joint && &matrix != blocks[b].data()) matrix.owner = {};
        group.matrices.push_back(std::move(matrix));
      }
    }
    bake->compression = count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 0.0;
    double lost = 0.0, all = 0.0;
    for (TransferGroup& group : bake->groups) {
      sum_errors(&group);
      lost += static_cast<double>(group.vertices.size()) * group.fit.error * group.fit.error;
      all += static_cast<double>(group.vertices.size());
    }
    bake->materials = all > 0.0 ? std::sqrt(lost / all) : 0.0;
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
  glm::dmat3 baked_from_world_{1.0};
  std::vector<glm::vec3> occluders_;
  Bounces bounces_;
  MaterialFits fits_;
  std::vector<TransferBlock> blocks_;
  std::size_t done_ = 0;
  RankPatience patience_;
};

}  // namespace

std::size_t TransferBake::bytes_per_vertex(const TransferGroup& group) const {
  const std::size_t records = group.fit.joint ? group.fit.joint->function_count() : group.matrices.size();
  return records * static_cast<std::size_t>(1 + options.components) * sizeof(std::uint16_t);
}

std::string transfer_folder(const std::string& folder, const std::string& scene, const std::string& key) {
  if (!folder.empty()) return (fs::path(folder) / (bake_name_of_scene(scene) + "-prt")).string();
  const auto cache = cache_folder();
  return cache ? (*cache / ("prt-" + key)).string() : std::string();
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

bool is_whole_transfer(const std::string& folder) {
  try {
    std::error_code ignored;
    if (!fs::exists(transfer_manifest_path(folder), ignored)) return false;
    const TransferSummary summary = summarize_transfer(folder);
    return summary.blocks_done == summary.blocks;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace maquette
