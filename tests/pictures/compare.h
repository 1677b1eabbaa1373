#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scenes/image.h"
#include "tests/pictures/cases.h"

namespace maquette::pictures {

struct PictureDifference {
  double largest = 0.0;        ///< of |a - b| / max(|base|, mean of |base|), over pixels and channels
  double failing_share = 0.0;  ///< of the pixels: those where it is above kTolerance
};
constexpr double kTolerance = 1e-6;
/// What an adaptive case may fail at.
constexpr double kAdaptiveShare = 1e-3;

/// NaN equals NaN only, infinity the same infinity. Pictures of other sizes differ everywhere.
PictureDifference compare_pictures(const Image& base, const Image& picture);

/// Prints the table of all cases drawn in both folders and of those that failed in one. True when all are the same.
bool compare_folders(const std::filesystem::path& base, const std::filesystem::path& pictures,
                     const std::vector<PictureCase>& cases);

}  // namespace maquette::pictures
