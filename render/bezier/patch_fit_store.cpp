#include "render/bezier/patch_fit_store.h"

#include <algorithm>
#include <utility>

namespace maquette {

std::optional<PatchFits> run_patch_fit_job(const PatchFitJob& job, const std::atomic<bool>& cancel,
                                           const std::function<void(double)>& progress) {
  std::size_t all = 0, done = 0;  // triangles
  for (const PatchFitPart& part : job) all += part.indices.size() / 3;
  PatchFits fits;
  for (const PatchFitPart& part : job) {
    const std::size_t own = part.indices.size() / 3;
    const auto report = [&](double share) {
      progress((static_cast<double>(done) + share * static_cast<double>(own)) /
               static_cast<double>(std::max<std::size_t>(all, 1)));
    };
    std::optional<PatchFit> fit;
    if (part.cage) fit = limit_patches_of(*part.cage, part.world_from_node, part.positions, part.normals, part.indices);
    if (!fit && !cancel)
      fit = fit_patches(part.positions, part.normals, part.uvs, part.indices,
                        {.stop = [&] { return cancel.load(); }, .report = report});
    if (cancel) return std::nullopt;
    fits[part.hash] = std::make_shared<const PatchFit>(std::move(*fit));
    done += own;
  }
  return fits;
}

Baked<PatchFits> PatchFitKind::run(const PatchFitJob& job, const Baked<PatchFits>&, const BakeTask<PatchFits>& task) {
  std::optional<PatchFits> fits = run_patch_fit_job(job, task.cancel, task.progress);
  if (!fits) return {};
  return {std::make_shared<const PatchFits>(std::move(*fits)), true};
}

void PatchFitStore::want(const std::vector<std::uint64_t>& hashes,
                         const std::function<PatchFitPart(std::size_t)>& make_part) {
  std::erase_if(fits_, [&](const auto& fit) { return std::ranges::find(hashes, fit.first) == hashes.end(); });
  std::vector<std::uint64_t> missing;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < hashes.size(); ++i) {
    if (fits_.contains(hashes[i]) || std::ranges::find(missing, hashes[i]) != missing.end()) continue;
    missing.push_back(hashes[i]);
    places.push_back(i);
  }
  if (missing.empty()) return cancel();
  require(std::move(missing), [&] {
    PatchFitJob job;
    for (const std::size_t i : places) job.push_back(make_part(i));
    return job;
  });
}

bool PatchFitStore::update() {
  const std::shared_ptr<const PatchFits> done = take();
  if (!done) return false;
  fits_.insert(done->begin(), done->end());
  return true;
}

std::shared_ptr<const PatchFit> PatchFitStore::find(std::uint64_t hash) const {
  const auto found = fits_.find(hash);
  return found == fits_.end() ? nullptr : found->second;
}

std::size_t PatchFitStore::bytes() const {
  std::size_t sum = 0;
  for (const auto& [hash, fit] : fits_)
    sum += fit->patches.size() * sizeof(FittedPatch) + fit->triangles.size() * sizeof(FittedTriangle);
  return sum;
}

}  // namespace maquette
