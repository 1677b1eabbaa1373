#include "tests/pictures/cases.h"

#include <algorithm>

namespace maquette::pictures {

PictureCase picture_of(const std::string& name, const std::string& scene, const std::vector<std::string>& words,
                       bool adaptive) {
  PictureCase c{name, {"render", scene, "-o", kPictures + "/" + name + ".exr"}, adaptive};
  c.words.insert(c.words.end(), words.begin(), words.end());
  for (const auto& [option, value] : {std::pair{"--size", "160x96"}, {"--samples", "16"}})
    if (std::ranges::find(words, option) == words.end()) c.words.insert(c.words.end(), {option, value});
  return c;
}

std::vector<PictureCase> all_cases(const Places& places) {
  std::filesystem::create_directories(places.inputs);
  std::vector<PictureCase> all = single_cases(places);
  for (PictureCase& c : sequence_cases(places)) all.push_back(std::move(c));
  return all;
}

}  // namespace maquette::pictures
