/// Sample count factor of a point that enters at `enters`. It is above 1 because finer points interpolate from this one and inherit its error.
/// The block of the first frame bounds it from above. `share`: as interpolation_error.comp found it, in grid points.
float sample_share(float share, int enters, int level) {
  int pixel_level = findMSB(u_frame.size.z);
  return enters > pixel_level ? min(max(share, 1.0), block_share(min(level, enters))) : block_share(min(level, enters));
}

/// Number of items that interpolation saves at a point. `worth`: kappa, share; `deviation`: of one sample.
float saved_items(vec2 worth, int enters, float have, float residual, float deviation) {
  float saved = interpolation_items(have > 0.0 ? point_kappa(worth.x, have, residual, item_variance(deviation, u_frame.sampling.y)) : worth.x);
  // Where the coarser points lie on other surfaces there is no interpolated value.
  return enters >= u_frame.size.w || (have > 0.0 && residual < 0.0) ? 0.0 : saved;
}

/// Total number of work items that a point should have. Neyman allocation: in proportion to its deviation, minus the items that interpolation
/// saves. This minimises the sum of sigma^2 / (n + n0) for a given sum of n. `scaled_deviation`: times the rate; `share`, `saved`: as above.
float wanted_items(float scaled_deviation, float share, float saved) { return scaled_deviation * share - saved; }
