#pragma once

#include <string>
#include <utility>
#include <vector>

#include "scenes/image.h"

namespace maquette {

/// What a technique has stored for a point of the picture, for people to see.
struct PointReport {
  std::vector<std::pair<std::string, std::string>> values;  ///< name, value with its unit
  struct Picture {
    std::string name;
    Image image;  ///< RGB, cd/m2; alpha 0 where there is nothing
  };
  std::vector<Picture> pictures;  ///< to be shown with one exposure
};

}  // namespace maquette
