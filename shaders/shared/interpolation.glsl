// Error of interpolation between coarser points while nothing moves. The errors of a point's own mean of n work items and of the value
// interpolated there are independent (finer points use coarser ones, never the reverse), so their mean, each weighted by the other's squared error,
// errs less than both. `kappa` is the squared error of interpolation in units of the variance of one item. It is estimated by tiles of the picture,
// grid levels and classes: points that the first frame shaded lie in sharper parts than points that it filled.
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif
const int kClasses = 2;
const float kNeverInterpolate = 1e9f;

/// The grid level that a point enters at: the largest whose spacing divides its coordinates.
MAQUETTE_FN int level_entered(int x, int y, int top) { return min(min(findLSB(x | (1 << top)), findLSB(y | (1 << top))), top); }

/// `block_level`: of the block around, as the first frame had it (marks, y).
MAQUETTE_FN int worth_layer(int enters, int block_level) { return kClasses * enters + (block_level > enters ? 1 : 0); }

/// Variance of one item of `samples`, from the deviation of one sample.
MAQUETTE_FN float item_variance(float deviation, int samples) { return deviation * deviation / float(samples); }

/// Variance of the mean of n items relative to that of one. The items continue one low-discrepancy sequence: for 3 to 400 items the measured
/// exponents are 1.5 to 1.7 on the Ferrari, plate, matte and paint, 1.2 to 1.3 on chrome. Too steep an exponent trusts own means too early, too flat
/// a one blurs. The first kEarlyItems are nearly independent (1 / n); from kEarlyItems^2 items on the power law holds.
const float kNoiseExponent = 1.5f, kEarlyItems = 2.5f;
MAQUETTE_FN float noise_fall(float items) {
  float n = max(items, 1e-3f);
  return max(pow(n, -kNoiseExponent), min(1.0f / n, kEarlyItems / (n * n)));
}

/// Weight of the own mean against the interpolated value.
MAQUETTE_FN float own_weight(float items, float kappa) { return items > 0.0f ? kappa / (kappa + noise_fall(items)) : 0.0f; }

/// Number of own items whose mean would err as much as interpolation.
MAQUETTE_FN float interpolation_items(float kappa) {
  float k = max(kappa, 1e-9f);  // inverse of noise_fall, piecewise
  return max(pow(k, -1.0f / kNoiseExponent), min(1.0f / k, sqrt(kEarlyItems / k)));
}

/// `kappa` of one point. `residual`: squared difference of its own mean and its interpolated value; below 0: not known. The kappa of the surroundings
/// may be wrong for an outlier: half of `residual`, minus the noise of the own mean, is a lower bound from the point itself.
/// So the weight of interpolation falls with the difference.
/// Source: Efron and Morris 1972, "Limiting the risk of Bayes and empirical Bayes estimators". The half: smallest error in four scenes
/// (docs/numerics/accumulation-and-reuse.md).
MAQUETTE_FN float point_kappa(float kappa, float items, float residual, float item_variance) {
  if (residual <= 0.0f || item_variance <= 0.0f) return kappa;  // a deviation of 0 has not been measured
  return max(kappa, min(residual / (2.0f * item_variance), kNeverInterpolate) - noise_fall(items));
}

/// `sums` over measured points: weighted squared difference of own mean and interpolated value, noise in it, variance of one item; unweighted count.
///
/// The estimate from a few points is noisy. Therefore the value of the picture's other tiles (`typical`) is added with the weight of kTypicalPoints
/// points (empirical Bayes). Source: Efron and Morris 1973, "Stein's Estimation Rule and Its Competitors - An Empirical Bayes Approach".
/// The result is at least kLeastNoise times the noise of one measurement, because smaller values cannot be measured.
const float kTypicalPoints = 4.0f, kLeastNoise = 0.35f;
MAQUETTE_FN float pooled_kappa(vec4 sums, float typical) {
  if (sums.w <= 0.0f || sums.z <= 0.0f) return typical;
  float item = sums.z / sums.w, noise = sums.y / sums.w;  // of one measurement
  float kappa = (max(sums.x - sums.y, 0.0f) + kTypicalPoints * item * typical) / (sums.z + kTypicalPoints * item);
  return max(kappa, kLeastNoise * noise / sums.z);
}
