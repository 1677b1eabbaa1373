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
/// which limits it. The half is by error in four scenes (docs/numerics.md).
MAQUETTE_FN float point_kappa(float kappa, float items, float residual, float item_variance) {
  if (residual <= 0.0f || item_variance <= 0.0f) return kappa;  // a deviation of 0 is one that nobody has looked for
  return max(kappa, min(residual / (2.0f * item_variance), kNeverInterpolate) - noise_fall(items));
}

/// `sums` over measured points: weighted squared distance of own mean and interpolated value, noise in it, variance of one item; unweighted count.
///
/// Was all noise taken out, chance would make interpolation look better than it is just as often as worse, and be trusted then. Two
/// measurements' worth of noise stays, by which the squared error is nowhere above that of own means alone. Source: James and Stein 1961,
/// "Estimation with quadratic loss", Sec. 2. One measurement's worth stays in any case: more is not known.
/// `unmeasured`: where there are none.
MAQUETTE_FN float pooled_kappa(vec4 sums, float unmeasured) {
  if (sums.w <= 0.0f || sums.z <= 0.0f) return unmeasured;
  float noise = sums.y / sums.w;
  return max(sums.x - sums.y + 2.0f * min(noise, 0.5f * sums.y), noise) / sums.z;
}
