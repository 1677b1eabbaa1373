#pragma once

#include <vector>

#include "render/technique/registry.h"
#include "render/technique/word.h"

namespace maquette {

/// Words that are names of techniques as well, for those that write them: a contract, whatever a technique is called.
namespace words {
inline constexpr const char* kOctree = "octree";
inline constexpr const char* kBandwidth = "bandwidth";
}  // namespace words

/// The words that every frame may use, then those of techniques.
std::vector<Word> vocabulary(const Registry& registry);

}  // namespace maquette
