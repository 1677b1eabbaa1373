// What interpolation between coarser points is worth while nothing moves. A point's own mean of n work items and the value interpolated there
// err independently of each other (finer points use coarser ones, never the reverse): weighted by the other's error they err less than either.
// The squared error of interpolation is kept as `kappa`, in units of the variance of one item, by tiles of the picture, grid levels and classes:
// what the first frame shaded is sharper than what it filled.
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

/// Variance of the mean of n items over that of one. They go on with one low-discrepancy sequence: own means of 3 to 400 items fall with
/// powers of 1.5 to 1.7 on the Ferrari, plate, matte and paint, 1.2 to 1.3 on chrome. Too steep a fall trusts own means too early, too flat a
/// one blurs. The first kEarlyItems are as good as independent, and fall with 1 / n; from kEarlyItems^2 on nothing of that is left.
const float kNoiseExponent = 1.5f, kEarlyItems = 2.5f;
MAQUETTE_FN float noise_fall(float items) {
  float n = max(items, 1e-3f);
  return max(pow(n, -kNoiseExponent), min(1.0f / n, kEarlyItems / (n * n)));
}

/// Weight of the own mean against the interpolated value.
MAQUETTE_FN float own_weight(float items, float kappa) { return items > 0.0f ? kappa / (kappa + noise_fall(items)) : 0.0f; }

/// How many items of its own a point would need to err as little as interpolation does.
MAQUETTE_FN float interpolation_items(float kappa) {
  float k = max(kappa, 1e-9f);  // noise_fall turned round, part by part
  return max(pow(k, -1.0f / kNoiseExponent), min(1.0f / k, sqrt(kEarlyItems / k)));
}

/// `kappa` of one point, whose own mean and interpolated value were `residual` apart (squared; below 0: not known). What holds around it need
/// not hold for a point that stands out: `residual` less its noise is what the point itself says of kappa, and half of `residual` is believed.
/// What is borrowed then falls with the distance. Source: Efron and Morris 1972, "Limiting the risk of Bayes and empirical Bayes estimators",
/// which limits it. The half is by error in four scenes (docs/numerics/accumulation-and-reuse.md).
MAQUETTE_FN float point_kappa(float kappa, float items, float residual, float item_variance) {
  if (residual <= 0.0f || item_variance <= 0.0f) return kappa;  // a deviation of 0 is one that nobody has looked for
  return max(kappa, min(residual / (2.0f * item_variance), kNeverInterpolate) - noise_fall(items));
}

/// `sums` over measured points: weighted squared distance of own mean and interpolated value, noise in it, variance of one item; unweighted count.
///
/// A handful of points says little: chance makes interpolation look worse than it is as often as better. So what holds for the picture's
/// tiles (`typical`) counts as kTypicalPoints more, in the manner of empirical Bayes. Source: Efron and Morris 1973, "Stein's Estimation Rule and
/// Its Competitors - An Empirical Bayes Approach". And some of one measurement's noise stays in any case: more is not known.
const float kTypicalPoints = 4.0f, kLeastNoise = 0.35f;
MAQUETTE_FN float pooled_kappa(vec4 sums, float typical) {
  if (sums.w <= 0.0f || sums.z <= 0.0f) return typical;
  float item = sums.z / sums.w, noise = sums.y / sums.w;  // of one measurement
  float kappa = (max(sums.x - sums.y, 0.0f) + kTypicalPoints * item * typical) / (sums.z + kTypicalPoints * item);
  return max(kappa, kLeastNoise * noise / sums.z);
}
