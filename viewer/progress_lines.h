#pragma once

#include <functional>
#include <string>

namespace maquette {

/// Prints a line on standard error whenever another tenth of something is done.
std::function<void(const std::string& what, double share)> print_progress();

}  // namespace maquette
