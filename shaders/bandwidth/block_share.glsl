/// Sample count factor of a point that stands for blocks of 2^level grid points. Below one pixel (multisampling) the box filter
/// averages the points, so together they take one pixel's samples; above, the count grows with the side of the block.
float block_share(int level) {
  int pixel_level = findMSB(u_frame.size.z);
  int below = min(level - pixel_level, 0), above = max(level - pixel_level, 0);
  return exp2(float(2 * below + above));
}

/// Pixels of a picture whose blocks take the samples that block_share says.
const float kSharedPixels = 640.0 * 360.0;

/// The same for the first samples of a frame. A larger picture shows the same part of the view by more pixels, so there a block takes what it takes
/// in one of kSharedPixels, and no pixel less than its own.
float block_share_of_view(int level) {
  float pixels = float(u_frame.size.x) * float(u_frame.size.y) * exp2(float(-2 * findMSB(u_frame.size.z)));
  float share = block_share(level);
  return share > 1.0 ? max(share * inversesqrt(max(pixels / kSharedPixels, 1.0)), 1.0) : share;
}
