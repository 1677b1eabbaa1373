#pragma once

#include <string>

namespace maquette {

/// How a debug view's values become a picture.
enum class ViewColors {
  scale,     ///< false colours over the range of the values
  radiance,  ///< tone mapped at the mean grey
  normal,    ///< components from -1 to 1
  color,     ///< linear colours
};

/// One debug view: an intermediate of the frame that can be shown instead of the picture (`--view`).
struct DebugViewInfo {
  std::string name;
  std::string help = {};
  ViewColors colors = ViewColors::scale;
};

}  // namespace maquette
