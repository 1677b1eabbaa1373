#pragma once

#include <memory>
#include <string>

#include "scenes/scene.h"

namespace maquette::bench {

/// A cloth of 3,364 vertices that lies over a ball and falls in folds around it. `cover`: its measured material.
std::shared_ptr<const Scene> cloth_covered(const std::string& cover);

}  // namespace maquette::bench
