#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace maquette::pictures {

/// One call of a program, `maquette WORDS...`. What it draws begins with the case's name.
struct PictureCase {
  std::string name;
  std::vector<std::string> words;
  /// How many samples a point gets follows from what was measured (mode bandwidth over several frames): a last bit may
  /// give a point more or fewer of them, so a few pixels may differ.
  bool adaptive = false;
};

/// Where the cases find and leave files. In their words `{pictures}` stands for the folder of the pictures, which is
/// another one for each program.
struct Places {
  std::filesystem::path inputs;  ///< scenes and reviews that are made here (write_inputs)
  std::filesystem::path data;    ///< real files; cases whose file is not there are left out
};
inline const std::string kPictures = "{pictures}";

/// The table, in the order in which it is drawn. `places.inputs` gets its scenes and reviews.
std::vector<PictureCase> all_cases(const Places& places);

// Its parts, one a source file.
std::vector<PictureCase> single_cases(const Places& places);
std::vector<PictureCase> sequence_cases(const Places& places);

/// `render SCENE -o {pictures}/NAME.exr WORDS...` at 160 x 96 pixels and 16 samples, where the words say nothing else.
PictureCase picture_of(const std::string& name, const std::string& scene, const std::vector<std::string>& words,
                       bool adaptive = false);

}  // namespace maquette::pictures
