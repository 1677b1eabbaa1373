#pragma once

#include <functional>
#include <string>

namespace maquette {

/// Content of an HDR file. channels: 3, or 4 with alpha; a luminance-only file counts as 3.
struct HdrInfo {
  int width = 0;
  int height = 0;
  int channels = 0;
};

/// Called once, before any row; may throw to stop the reading (e.g. too large).
using HdrBegin = std::function<void(const HdrInfo&)>;
/// `row_count` rows from `first_row` on, interleaved floats, in ascending order without gaps.
using HdrRows = std::function<void(int first_row, int row_count, const float* values)>;

/// Reads .exr or .hdr strip by strip, so that a huge map is never in memory as a whole. The content decides on the
/// format. EXR: scan lines or tiles (level 0), half, float or uint, R G B (A), luminance Y, or Y RY BY; first flat part
/// that has them; the data window. Radiance: RLE or flat, `-Y +X`; EXPOSURE and COLORCORR lines are ignored, as most
/// readers do. Throws Error: unreadable, unknown format, truncated, no such channels, invalid size.
void stream_hdr_image(const std::string& path, const HdrBegin& begin, const HdrRows& rows);

/// The readers of the two formats; `path` exists and has the right magic number.
void stream_exr(const std::string& path, const HdrBegin& begin, const HdrRows& rows);
void stream_radiance(const std::string& path, const HdrBegin& begin, const HdrRows& rows);

/// Throws Error unless 1 <= width, height <= 65,536 and the image has at most 2^30 texels.
void check_image_size(const std::string& path, long long width, long long height);

}  // namespace maquette
