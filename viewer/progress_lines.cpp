#include "viewer/progress_lines.h"

#include <cstdio>

#include "viewer/print.h"

namespace maquette {

std::function<void(const std::string&, double)> print_progress() {
  return [shown = std::string(), tenths = -1](const std::string& what, double share) mutable {
    const int percent = static_cast<int>(100.0 * share);
    if (what == shown && percent / 10 == tenths) return;
    shown = what;
    tenths = percent / 10;
    print_line(stderr, "%s: %d %%\n", what.c_str(), percent);
  };
}

}  // namespace maquette
