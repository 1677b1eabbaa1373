#pragma once

#include <cstdint>
#include <string>

namespace maquette {

/// Whether the cache has an entry that cache_load (scenes/files.h) would read, by its header and length: bytes that are
/// damaged in place are found only when they are read.
bool cache_holds(const std::string& kind, int version, std::uint64_t key);

}  // namespace maquette
