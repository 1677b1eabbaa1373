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
  if (missing == asked_) return;
  cancel();
  if (missing.empty()) return;
  PatchFitJob job;
  for (const std::size_t i : places) job.push_back(make_part(i));
  if (!worker_) worker_ = std::make_unique<BackgroundWorker<PatchFitJob, PatchFits>>(run_patch_fit_job);
  worker_->submit(std::move(job));
  asked_ = std::move(missing);
}

bool PatchFitStore::update() {
  std::optional<PatchFits> done = worker_ ? worker_->take() : std::nullopt;
  if (!done) return false;
  fits_.merge(*done);
  asked_.clear();
  return true;
}

std::shared_ptr<const PatchFit> PatchFitStore::find(std::uint64_t hash) const {
  const auto found = fits_.find(hash);
  return found == fits_.end() ? nullptr : found->second;
}

void PatchFitStore::cancel() {
  if (asked_.empty()) return;
  worker_->cancel();
  asked_.clear();
}

}  // namespace maquette
