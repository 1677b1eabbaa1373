// maquette_pictures draw FOLDER [--data FOLDER] [--only REGEX]: the cases that FOLDER does not have yet.
// maquette_pictures compare BASE FOLDER [--only REGEX]: their table; exit code 0 when all are the same.
// maquette_pictures list [--only REGEX]: their names.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <regex>

#include "render/gl/context.h"
#include "tests/pictures/cases.h"
#include "tests/pictures/compare.h"

namespace {

using namespace maquette;
using namespace maquette::pictures;
namespace fs = std::filesystem;

struct Arguments {
  std::string command;
  std::vector<std::string> folders;
  std::string data, only;
};

/// Throws a message for the caller.
Arguments parse(int count, char** values) {
  Arguments arguments;
  if (count > 1) arguments.command = values[1];
  for (int i = 2; i < count; ++i) {
    const std::string value = values[i];
    const bool is_option = value == "--data" || value == "--only";
    if (!is_option && value.starts_with("--")) throw std::invalid_argument(value + ": there is no such option");
    if (is_option && i + 1 == count) throw std::invalid_argument(value + ": a value is missing");
    if (is_option)
      (value == "--data" ? arguments.data : arguments.only) = values[++i];
    else
      arguments.folders.push_back(value);
  }
  const std::size_t wanted = arguments.command == "draw" ? 1 : arguments.command == "compare" ? 2 : 0;
  if (arguments.folders.size() != wanted || (wanted == 0 && arguments.command != "list"))
    throw std::invalid_argument(
        "usage: maquette_pictures draw FOLDER [--data FOLDER] | compare BASE FOLDER | list [--only REGEX]");
  return arguments;
}

std::vector<PictureCase> chosen_cases(const std::string& only) {
  std::vector<PictureCase> cases = all_cases();
  const std::regex pattern(only);
  std::erase_if(cases, [&](const PictureCase& c) { return !std::regex_search(c.name, pattern); });
  return cases;
}

void write_line(const fs::path& path, const std::string& line) { std::ofstream(path) << line << '\n'; }

/// Draws one case. While it is drawn its `.error` says so, for the case that the process ends.
std::string draw(const PictureCase& c, Library* library, const fs::path& folder) {
  const fs::path error = folder / (c.name + ".error"), skipped = folder / (c.name + ".skipped");
  fs::remove(skipped);
  write_line(error, "the process ended while it was drawn");
  try {
    Stage stage(library, folder, c.name);
    c.draw(&stage);
    write_line(folder / (c.name + ".done"), "done");
    fs::remove(error);
    return "done";
  } catch (const Skipped& reason) {
    write_line(skipped, reason.what());
    fs::remove(error);
    return std::string("skipped: ") + reason.what();
  } catch (const std::exception& fault) {
    take_gl_errors();
    write_line(error, fault.what());
    return std::string("ERROR: ") + fault.what();
  }
}

int draw_all(const std::vector<PictureCase>& cases, const Arguments& arguments) {
  const fs::path folder = arguments.folders[0];
  fs::create_directories(folder);
  const GlContext context = GlContext::create_headless();
  install_debug_output();
  Library library(arguments.data);
  int failed = 0;
  for (const PictureCase& c : cases) {
    if (fs::exists(folder / (c.name + ".done")) || fs::exists(folder / (c.name + ".error"))) continue;
    const auto start = std::chrono::steady_clock::now();
    const std::string result = draw(c, &library, folder);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    std::printf("%-40s %6.1f s  %s\n", c.name.c_str(), seconds, result.c_str());
    std::fflush(stdout);
    if (result.starts_with("ERROR")) ++failed;
  }
  return failed > 0 ? 1 : 0;
}

}  // namespace

int main(int count, char** values) {
  try {
    const Arguments arguments = parse(count, values);
    const std::vector<PictureCase> cases = chosen_cases(arguments.only);
    if (arguments.command == "draw") return draw_all(cases, arguments);
    if (arguments.command == "compare")
      return compare_folders(arguments.folders[0], arguments.folders[1], cases) ? 0 : 1;
    for (const PictureCase& c : cases) std::printf("%s%s\n", c.name.c_str(), c.adaptive ? " (adaptive)" : "");
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 2;
  }
}
