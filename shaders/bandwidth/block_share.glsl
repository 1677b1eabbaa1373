/// Sample count factor of a point that stands for blocks of 2^level grid points. Below one pixel (multisampling) the box filter
/// averages the points, so together they take one pixel's samples; above, the count grows with the side of the block.
float block_share(int level) {
  int pixel_level = findMSB(u_frame.size.z);
  int below = min(level - pixel_level, 0), above = max(level - pixel_level, 0);
  return exp2(float(2 * below + above));
}
