#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/pictures/stage.h"

namespace maquette::pictures {

struct PictureCase {
  std::string name;
  std::function<void(Stage*)> draw;
  /// How many samples a point gets follows from what was measured (mode bandwidth that accumulates or turns): a last
  /// bit may give a point more or fewer of them, so a few pixels may differ.
  bool adaptive = false;
};

/// The table, in the order in which it is drawn.
std::vector<PictureCase> all_cases();

// Its parts, one a source file.
std::vector<PictureCase> mode_cases();
std::vector<PictureCase> shading_cases();
std::vector<PictureCase> reflection_cases();
std::vector<PictureCase> motion_cases();
std::vector<PictureCase> edit_cases();
std::vector<PictureCase> file_cases();

}  // namespace maquette::pictures
