#include "render/visibility/visibility_worker.h"

namespace maquette {

VisibilityWorker::VisibilityWorker()
    : BackgroundWorker([](const VisibilityJob& job, const std::atomic<bool>& cancel,
                          const std::function<void(double)>& progress) -> std::optional<DrawnVisibility> {
        auto bake = load_visibility(job.geometry, job.transmits, job.passages, cancel, progress);
        if (!bake) return std::nullopt;
        std::vector<VisibilitySides> sides = visibility_sides(bake->vertices, job.geometry.normals);
        return DrawnVisibility{std::move(*bake), std::move(sides)};
      }) {}

}  // namespace maquette
