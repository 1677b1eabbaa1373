#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <optional>

#include "render/background_worker.h"
#include "render/indirect/indirect_light.h"

namespace maquette {

struct IndirectJob {
  std::shared_ptr<const IndirectInput> input;
  std::shared_ptr<const VisibilityBake> visibility;
  IndirectSky sky;
  IndirectBounces bounces = IndirectBounces::all;
};

/// What is kept from job to job of the same input, so that a sky that turns costs no rays.
struct IndirectMemory {
  std::shared_ptr<const IndirectInput> input;
  std::shared_ptr<const IndirectLinks> links;
  IndirectSolution solution;  ///< of the last job
};

/// The bake of a job, through the disk cache (by content). Rays are traced only when neither `memory` nor the cache has
/// the answer. Null once `cancel` is set, and for no bounces.
std::optional<IndirectBake> load_indirect(const IndirectJob& job, IndirectMemory* memory,
                                          const std::atomic<bool>& cancel,
                                          const std::function<void(double)>& progress = {});

struct IndirectResult {
  IndirectBake bake;
  IndirectSky sky;
  IndirectBounces bounces = IndirectBounces::all;
  std::shared_ptr<const IndirectInput> input;
};

/// Bakes indirect light on a thread of its own. A newer sky waits for the one in work (a light that turns all the time
/// would else never be seen); newer surfaces stop it.
class IndirectWorker : public BackgroundWorker<IndirectJob, IndirectResult> {
 public:
  using Result = IndirectResult;
  IndirectWorker();
};

}  // namespace maquette
