#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "render/bake/bake_runner.h"
#include "render/bezier/patch_fit.h"

namespace maquette {

/// A part of the scene that patches are to be fitted to, by value: the scene may change meanwhile.
struct PatchFitPart {
  std::uint64_t hash = 0;  ///< of positions, normals, texture coordinates and indices
  std::vector<glm::vec3> positions, normals;
  std::vector<glm::vec2> uvs;
  std::vector<std::uint32_t> indices;           ///< three a triangle, of those
  std::shared_ptr<const SubdivisionCage> cage;  ///< of a subdivision surface, else null
  glm::dmat4 world_from_node{1.0};              ///< of the cage
};

using PatchFitJob = std::vector<PatchFitPart>;
using PatchFits = std::map<std::uint64_t, std::shared_ptr<const PatchFit>>;  ///< by PatchFitPart::hash

/// The limit's own patches where the part is a subdivision surface that has few, else fitted ones. Nothing once
/// `cancel` is set.
std::optional<PatchFits> run_patch_fit_job(const PatchFitJob& job, const std::atomic<bool>& cancel,
                                           const std::function<void(double)>& progress);

class PatchFitKind : public BakeKind<PatchFitJob, PatchFits> {
 public:
  Baked<PatchFits> run(const PatchFitJob&, const Baked<PatchFits>&, const BakeTask<PatchFits>&) override;
};

/// The fits that a scene's reflectors need.
class PatchFitStore final : public KeyedBake<std::vector<std::uint64_t>, PatchFitJob, PatchFits> {
 public:
  PatchFitStore() : KeyedBake(std::make_shared<PatchFitKind>()) {}
  const char* name() const override { return "patch_fit"; }
  /// Keeps the fits of these hashes alone, and starts those that are missing; what works on others is cancelled.
  /// `make_part`: of the hash at an index.
  void want(const std::vector<std::uint64_t>& hashes, const std::function<PatchFitPart(std::size_t)>& make_part);
  /// Takes over what is done; true when it was. Throws what made a fit fail, once.
  bool update();
  /// Null while it is not there.
  std::shared_ptr<const PatchFit> find(std::uint64_t hash) const;
  bool ready() const override { return !fits_.empty(); }
  std::size_t bytes() const override;

 private:
  PatchFits fits_;
};

}  // namespace maquette
