#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "scenes/btf/btf_reading.h"
#include "scenes/scene.h"
#include "viewer/options.h"

namespace maquette {

/// Makes the BTFs of options and scene that are not in the cache yet, with their progress on standard error; Ctrl-C
/// ends it. What draws them then finds them there. With
/// `draws` it says so where the mode of the options draws their mean alone. Throws Error.
void prepare_btfs(const SceneOptions& options, const Scene& scene, bool draws = true);
void prepare_btf(const std::string& source);

/// Progress on standard error, cancelled by a flag.
BtfTask print_btf_task(const std::atomic<bool>& cancel);

}  // namespace maquette
