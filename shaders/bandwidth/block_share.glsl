/// Sample count factor of a point that represents a block with a side of 2^level grid points. Blocks smaller than a pixel (multisampling) are
/// averaged by the box filter, so together they get one pixel's samples; for larger blocks the count grows with the side of the block.
float block_share(int level) {
  int pixel_level = findMSB(u_frame.size.z);
  int below = min(level - pixel_level, 0), above = max(level - pixel_level, 0);
  return exp2(float(2 * below + above));
}

/// Number of pixels of a picture for which block_share is used unchanged.
const float kSharedPixels = 640.0 * 360.0;

/// The same for the first samples of a frame. A larger picture shows the same part of the view with more pixels, so its blocks get the samples
/// of the same part of the view in a picture of kSharedPixels pixels, but at least those of one pixel.
float block_share_of_view(int level) {
  float pixels = float(u_frame.size.x) * float(u_frame.size.y) * exp2(float(-2 * findMSB(u_frame.size.z)));
  float share = block_share(level);
  return share > 1.0 ? max(share * inversesqrt(max(pixels / kSharedPixels, 1.0)), 1.0) : share;
}
