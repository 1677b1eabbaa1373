#include "viewer/bake_clock.h"

namespace maquette {

std::map<std::string, double> BakeClock::update(double now_s, const std::vector<BackgroundWork>& works) {
  std::map<std::string, Run> runs;
  std::map<std::string, double> left;
  for (const BackgroundWork& work : works) {
    const auto known = runs_.find(work.what);
    // Progress that falls is that of another run.
    Run run =
        known == runs_.end() || work.fraction < known->second.last ? Run{now_s, work.fraction, 0.0} : known->second;
    run.last = work.fraction;
    const double seconds = now_s - run.begin_s;
    if (seconds < 1.0) run.begin = work.fraction;  // what was read from the disk
    const double made = work.fraction - run.begin;
    if (seconds >= 2.0 && made >= 0.02) left[work.what] = seconds * (1.0 - work.fraction) / made;
    runs[work.what] = run;
  }
  runs_ = std::move(runs);
  return left;
}

}  // namespace maquette
