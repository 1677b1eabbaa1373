#include "tests/pictures/cases.h"

namespace maquette::pictures {

std::vector<PictureCase> all_cases() {
  std::vector<PictureCase> all;
  for (const auto part : {mode_cases, shading_cases, reflection_cases, motion_cases, edit_cases, file_cases})
    for (PictureCase& c : part()) all.push_back(std::move(c));
  return all;
}

}  // namespace maquette::pictures
