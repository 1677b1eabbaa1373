#pragma once

#include <string>

#include "render/frame/status.h"
#include "render/technique/registry.h"

namespace maquette::panels {

/// What there is of a bake, in words. `busy`: it is being made; `held`: the user stopped it.
std::string bake_state_text(const BakeStatus& bake, bool busy, bool held);

/// What a bake decides in the picture; empty for what is none.
std::string bake_effect(const Registry& registry, const std::string& bake);

}  // namespace maquette::panels
