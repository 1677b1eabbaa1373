#include "render/visibility/visibility_worker.h"

namespace maquette {

VisibilityWorker::VisibilityWorker()
    : BackgroundWorker(
          [](const VisibilityJob& job, const std::atomic<bool>& cancel, const std::function<void(double)>& progress) {
            return load_visibility(job.geometry, job.transmits, job.passages, cancel, progress);
          }) {}

}  // namespace maquette
