#pragma once

#include <functional>
#include <string>

#include "viewer/report/data.h"
#include "viewer/report/journal.h"
#include "viewer/report/studio.h"

namespace maquette::report {

/// A reference picture: the mean of two halves with equal effort and independent seeds.
struct Judge {
  Image picture;
  Image halves[2];
  ReferenceEntry entry;
  std::string key;
};

struct ReferenceOrder {
  SweptCamera camera;
  Scope scope = Scope::model;
  double seconds = 10.0;        ///< to spend on it, about
  double target_noise = 0.003;  ///< relative RMSE at which it is good enough
};

/// Relative RMSE of a picture against what the reference would be without noise: the mean over the pixels of
/// (a - r1) (a - r2), whose expectation is (a - r)^2 because the halves' noise is independent. Absent for a black
/// reference; at least a tenth of the plain error, where noise makes the mean negative.
std::optional<double> noise_free_error(const Image& picture, const Judge& judge);

/// The reference of one camera in scope estimator (unshadowed direct light) or model (all light paths): read from the
/// folder if an earlier run made it for the same content, else computed and stored there. Throws Error when it cannot
/// be written.
Judge obtain_reference(Studio* studio, Journal* journal, const std::string& folder, const ReferenceOrder& order);

/// One frame with reflections by the technique that judges the others (Capabilities::is_exact) at its best step, without noise; stored in the folder. Nothing when no
/// reflector is in view. Throws Error when it cannot be written.
std::optional<Judge> obtain_reflection_reference(Studio* studio, const std::string& folder, const SweptCamera& camera,
                                                 const SweptTechnique& exact);

}  // namespace maquette::report
