#pragma once

#include <atomic>

namespace maquette {

/// For work that is not cancelled.
inline const std::atomic<bool> kNever{false};

}  // namespace maquette
