#pragma once

#include <string>

#include "render/frame/status.h"

namespace maquette::panels {

/// What there is of a bake, in words. `busy`: it is being made; `held`: the user stopped it.
std::string bake_state_text(const BakeStatus& bake, bool busy, bool held);

}  // namespace maquette::panels
