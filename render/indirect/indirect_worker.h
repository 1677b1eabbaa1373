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
};

/// The bake of a job, through the disk cache (by content). `links` holds those of the last input, so that a sky that
/// turns costs no rays; they are traced only when the cache does not have the answer. Null once `cancel` is set.
std::optional<IndirectBake> load_indirect(const IndirectJob& job, std::shared_ptr<const IndirectLinks>* links,
                                          const std::atomic<bool>& cancel,
                                          const std::function<void(double)>& progress = {});

struct IndirectResult {
  IndirectBake bake;
  IndirectSky sky;
  std::shared_ptr<const IndirectInput> input;
  std::size_t link_bytes = 0;
};

/// Bakes indirect light on a thread of its own. A newer sky waits for the one in work (a light that turns all the time
/// would else never be seen); newer surfaces stop it.
class IndirectWorker : public BackgroundWorker<IndirectJob, IndirectResult> {
 public:
  using Result = IndirectResult;
  IndirectWorker();
};

}  // namespace maquette
