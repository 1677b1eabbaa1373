/// Share of the samples of a point that enters at `enters`: finer points that borrow from it see its error too. The first frame's block
/// bounds it from above. `share`: as worth.comp found it, in grid points.
float sample_share(float share, int enters, int level) {
  int pixel_level = findMSB(u_frame.size.z);
  return enters > pixel_level ? min(max(share, 1.0), block_share(min(level, enters))) : block_share(min(level, enters));
}

/// Items that interpolation is worth at a point. `worth`: kappa, share; `deviation`: of one sample.
float saved_items(vec2 worth, int enters, float have, float residual, float deviation) {
  float saved = interpolation_items(have > 0.0 ? point_kappa(worth.x, have, residual, item_variance(deviation, u_frame.sampling.y)) : worth.x);
  // Where the coarser points lie on other surfaces there is nothing to borrow.
  return enters >= u_frame.size.w || (have > 0.0 && residual < 0.0) ? 0.0 : saved;
}

/// Work items that a point should have in all. Neyman: in proportion to its deviation, less what interpolation is worth: the sum that
/// minimises sum of sigma^2 / (n + n0) for a given sum of n. `scaled_deviation`: times the rate; `share`, `saved`: as above.
float wanted_items(float scaled_deviation, float share, float saved) { return scaled_deviation * share - saved; }
