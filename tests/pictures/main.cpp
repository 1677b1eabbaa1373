// What scripts/same-pictures draws with the programs of two versions, and how it compares the pictures.
//
// maquette_pictures calls INPUTS [--data FOLDER] [--only REGEX]: writes scenes and reviews into INPUTS and prints a
// line for each case: its name and the words of the call, with tabs between. maquette_pictures compare INPUTS BASE
// FOLDER [--exact] [--data FOLDER] [--only REGEX]: their table; exit code 0 when all are the same.
#include <cstdio>
#include <regex>
#include <stdexcept>

#include "tests/pictures/cases.h"
#include "tests/pictures/compare.h"

namespace {

using namespace maquette::pictures;

struct Arguments {
  std::string command;
  std::vector<std::string> folders;
  std::string data, only;
  bool exact = false;
};

/// Throws a message for the caller.
Arguments parse(int count, char** values) {
  Arguments arguments;
  if (count > 1) arguments.command = values[1];
  for (int i = 2; i < count; ++i) {
    const std::string value = values[i];
    if (value == "--exact") {
      arguments.exact = true;
    } else if (value == "--data" || value == "--only") {
      if (i + 1 == count) throw std::invalid_argument(value + ": a value is missing");
      (value == "--data" ? arguments.data : arguments.only) = values[++i];
    } else if (value.starts_with("--")) {
      throw std::invalid_argument(value + ": there is no such option");
    } else {
      arguments.folders.push_back(value);
    }
  }
  if (arguments.folders.size() != (arguments.command == "compare" ? 3u : 1u) ||
      (arguments.command != "compare" && arguments.command != "calls"))
    throw std::invalid_argument("usage: maquette_pictures calls INPUTS | compare INPUTS BASE FOLDER [--exact]");
  return arguments;
}

std::vector<PictureCase> chosen_cases(const Arguments& arguments) {
  std::vector<PictureCase> cases = all_cases({std::filesystem::absolute(arguments.folders[0]), arguments.data});
  const std::regex pattern(arguments.only);
  std::erase_if(cases, [&](const PictureCase& c) { return !std::regex_search(c.name, pattern); });
  return cases;
}

}  // namespace

int main(int count, char** values) {
  try {
    const Arguments arguments = parse(count, values);
    const std::vector<PictureCase> cases = chosen_cases(arguments);
    if (arguments.command == "compare")
      return compare_folders(arguments.folders[1], arguments.folders[2], cases, arguments.exact ? kExact : Tolerance())
                 ? 0
                 : 1;
    for (const PictureCase& c : cases) {
      std::printf("%s", c.name.c_str());
      for (const std::string& word : c.words) std::printf("\t%s", word.c_str());
      std::printf("\n");
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 2;
  }
}
