#pragma once

#include <cstddef>
#include <vector>

namespace maquette {

/// Of the values in a region of a picture.
struct RegionStatistics {
  std::size_t count = 0;
  double min = 0.0, mean = 0.0, median = 0.0, max = 0.0;
  double sigma = 0.0;       ///< standard deviation over the pixels
  double share_over = 0.0;  ///< of the values above the threshold
};
/// All zero without values. The median of an even count is the mean of the middle two.
RegionStatistics region_statistics(std::vector<double> values, double threshold);

/// Mean of independent estimates and half the width of its 95 % interval (Student's t).
struct Interval {
  double mean = 0.0, half_width = 0.0;
};
/// `half_width` is infinite for fewer than two estimates.
Interval confidence_interval(const std::vector<double>& estimates);

}  // namespace maquette
