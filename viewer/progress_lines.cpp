#include "viewer/progress_lines.h"

#include <cstdio>

namespace maquette {

std::function<void(const std::string&, double)> print_progress() {
  return [shown = std::string(), tenths = -1](const std::string& what, double share) mutable {
    const int percent = static_cast<int>(100.0 * share);
    if (what == shown && percent / 10 == tenths) return;
    shown = what;
    tenths = percent / 10;
    std::fprintf(stderr, "%s: %d %%\n", what.c_str(), percent);
  };
}

}  // namespace maquette
