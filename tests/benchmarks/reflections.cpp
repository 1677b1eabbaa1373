// Reflection points on patches and triangles: two campaigns of a million cases each, with --repeats seeds.
#include <cstdio>

#include "tests/benchmarks/stage.h"
#include "tests/support/reflection_campaign.h"
#include "tests/support/triangle_campaign.h"

namespace maquette::bench {

namespace {

constexpr std::size_t kCases = 1000000;

Figures patches(std::uint64_t seed) {
  const BezierCampaign r = run_bezier_campaign(kCases, seed);
  std::fputs(r.failures.c_str(), stderr);
  return {
      judged("Bezier: wrong minima of 1e6 triples", "0",
             std::to_string(r.wrong) + " of " + std::to_string(r.inside) + " on the patch", r.wrong == 0),
      judged("Bezier: second minima where certified", "0", std::to_string(r.several), r.several == 0),
      judged("Bezier: law of reflection beyond 1e-4 rad", "0",
             std::to_string(r.law_broken) + ", worst " + number(r.worst_law_rad) + " rad", r.law_broken == 0),
      judged("Bezier: steps, 99th percentile on the patch", "5", std::to_string(r.steps_quantile(0.99)),
             r.steps_quantile(0.99) <= 5),
      shown("Bezier: marked, beyond a caustic", std::to_string(r.uncertified) + " besides"),
  };
}

Figures triangles(std::uint64_t seed) {
  const TriangleCampaign r = run_triangle_campaign(kCases, seed);
  std::fputs(r.failures.c_str(), stderr);
  return {
      judged("triangle: simple roots missed of 1e6 cases", "0",
             std::to_string(r.missed) + " of " + std::to_string(r.simple_roots) + ", worst " + number(r.worst_simple),
             r.missed == 0),
      judged("triangle: other roots off by 1e-4 of the size", "0",
             std::to_string(r.stray) + " of " + std::to_string(r.other_roots) + ", worst " + number(r.worst_stray),
             r.stray == 0),
      judged("triangle: root inside not chosen", "0", std::to_string(r.wrong_choice), r.wrong_choice == 0),
      judged("triangle: not finite", "0", std::to_string(r.not_finite), r.not_finite == 0),
  };
}

}  // namespace

Figures measure_reflections(Stage& stage) {
  Figures all;
  for (int seed = 1; seed <= stage.options().repeats; ++seed)
    for (Figures part : {patches(static_cast<std::uint64_t>(seed)), triangles(static_cast<std::uint64_t>(seed))})
      for (Figure& f : part) {
        f.name += ", seed " + std::to_string(seed);
        all.push_back(std::move(f));
      }
  return all;
}

}  // namespace maquette::bench
