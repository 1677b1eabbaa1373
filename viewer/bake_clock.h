#pragma once

#include <map>
#include <string>
#include <vector>

#include "render/renderer.h"

namespace maquette {

/// Tells from the progress of background work how long it still takes.
class BakeClock {
 public:
  /// `now_s`: of any clock. Returns the seconds left of each work that has gone on for 2 s and made 2 % meanwhile.
  std::map<std::string, double> update(double now_s, const std::vector<BackgroundWork>& works);

 private:
  struct Run {
    double begin_s = 0.0, begin = 0.0, last = 0.0;
  };
  std::map<std::string, Run> runs_;
};

}  // namespace maquette
