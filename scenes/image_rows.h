#pragma once

#include <functional>
#include <string>
#include <vector>

namespace maquette {

/// What a file is read for. A picture is its display window: 0 where the data window leaves it out, without the rest of
/// the data window. A map of the environment is its data window (OpenEXR, ImfEnvmap.h).
enum class HdrUse { picture, environment };

/// Content of an HDR file. channels: 3, or 4 with alpha; a luminance-only file counts as 3.
struct HdrInfo {
  int width = 0;
  int height = 0;
  int channels = 0;
  bool converted = false;  ///< from other primaries: colours outside Rec.709 have negative components
  std::vector<std::string> warnings;
};

/// Called once, before any row; may throw to stop the reading (e.g. too large).
using HdrBegin = std::function<void(const HdrInfo&)>;
/// `row_count` rows from `first_row` on, interleaved floats, in ascending order without gaps.
using HdrRows = std::function<void(int first_row, int row_count, const float* values)>;

/// Reads .exr or .hdr strip by strip as linear Rec.709, so that a huge map is never in memory as a whole. The content
/// decides on the format; docs/formats.md says what is read of each. Throws Error: unreadable, unknown format,
/// truncated, no such channels, invalid size.
void stream_hdr_image(const std::string& path, HdrUse use, const HdrBegin& begin, const HdrRows& rows);

/// The readers of the two formats; `path` exists and has the right magic number.
void stream_exr(const std::string& path, HdrUse use, const HdrBegin& begin, const HdrRows& rows);
void stream_radiance(const std::string& path, const HdrBegin& begin, const HdrRows& rows);

/// Throws Error unless 1 <= width, height <= 65,536 and the image has at most 2^30 texels.
void check_image_size(const std::string& path, long long width, long long height);

}  // namespace maquette
