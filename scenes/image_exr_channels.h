#pragma once

#include <OpenEXR/ImfMultiPartInputFile.h>

#include <string>
#include <vector>

namespace maquette {

/// One channel of one part.
struct ExrChannel {
  int part = 0;
  std::string name;
  int x_sampling = 1;
  int y_sampling = 1;
};

/// The channels that make up one picture: R G B, Y RY BY, or Y alone, then A if there is one.
struct ExrPicture {
  enum class Layout { rgb, luminance_chroma, luminance };
  Layout layout = Layout::rgb;
  std::string name;  ///< its part, view or layer
  std::vector<ExrChannel> channels;
  bool has_alpha = false;
};

/// The first complete picture of the flat parts: colour before luminance alone, channels without a layer before those
/// of a layer (`layer.R`), one part before several that belong together. Warns when it had the choice. Throws Error
/// naming what was found.
ExrPicture choose_exr_picture(const std::string& path, const Imf::MultiPartInputFile& file,
                              std::vector<std::string>* warnings);

}  // namespace maquette
