#pragma once

#include <filesystem>
#include <vector>

#include "scenes/image.h"
#include "tests/pictures/cases.h"

namespace maquette::pictures {

struct PictureDifference {
  double largest = 0.0;        ///< of |a - b| / max(|base|, mean of |base|), over pixels and channels
  double failing_share = 0.0;  ///< of the pixels: those where it is above the tolerance
};
/// What pictures may differ by.
struct Tolerance {
  double relative = 1e-6;
  double adaptive_share = 1e-3;  ///< of the pixels of an adaptive case that may differ by more
};
inline constexpr Tolerance kExact{0.0, 0.0};

/// NaN equals NaN only, infinity the same infinity. Pictures of other sizes differ everywhere.
PictureDifference compare_pictures(const Image& base, const Image& picture, double tolerance);

/// Prints the table of all cases, of which each folder has pictures, `NAME.exr` or `NAME/*.exr`, and where a program
/// failed `NAME.error`. True when all are the same.
bool compare_folders(const std::filesystem::path& base, const std::filesystem::path& pictures,
                     const std::vector<PictureCase>& cases, const Tolerance& tolerance);

}  // namespace maquette::pictures
