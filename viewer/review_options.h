#pragma once

#include <optional>

#include "review/review.h"
#include "viewer/options.h"

namespace maquette {

/// The review that the options name, nothing without one. Throws Error when files are missing that it needs: all of
/// them in one line.
std::optional<Review> review_of(const SceneOptions& options);

/// The look of a review that the options name, with what else they give on top. Throws UsageError with the nearest
/// names.
Look look_of_review(const Review& review, const Scene& scene, const SceneOptions& options);

/// For commands that vary a look by themselves: the review's scene and look as options; gives the look. Nothing without
/// a review.
std::optional<Look> take_review(SceneOptions* options);

}  // namespace maquette
