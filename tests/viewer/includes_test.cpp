#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include "test_paths.h"

namespace {

namespace fs = std::filesystem;

const std::map<std::string, int> kRanks = {{"scenes", 0}, {"render", 1}, {"ui", 2}, {"viewer", 3}};

std::vector<fs::path> source_files(const std::string& folder) {
  std::vector<fs::path> files;
  const fs::path root = fs::path(MAQUETTE_SOURCE_DIR) / folder;
  if (!fs::exists(root)) return files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root)) {
    const std::string extension = entry.path().extension();
    if (extension == ".cpp" || extension == ".h" || extension == ".glsl" || extension == ".comp" ||
        extension == ".vert" || extension == ".frag")
      files.push_back(entry.path());
  }
  return files;
}

std::string first_folder(const std::string& path) { return path.substr(0, path.find('/')); }

/// The includes of `text` that a file of `folder` must not have.
std::vector<std::string> upward_includes(std::istream& text, const std::string& folder) {
  static const std::regex kInclude(R"re(^\s*#\s*include\s*"([^"]+)")re");
  std::vector<std::string> found;
  std::smatch match;
  for (std::string line; std::getline(text, line);) {
    if (!std::regex_search(line, match, kInclude)) continue;
    const auto rank = kRanks.find(first_folder(match[1]));
    if (rank != kRanks.end() && rank->second > kRanks.at(folder)) found.push_back(match[1]);
  }
  return found;
}

TEST(Includes, TheRuleSeesAnUpwardInclude) {
  std::istringstream text("#include \"scenes/scene.h\"\n#include \"render/plan.h\"\n");
  EXPECT_EQ(upward_includes(text, "scenes"), std::vector<std::string>{"render/frame/plan.h"});
}

TEST(Includes, PointDownwardsOnly) {
  for (const auto& [folder, rank] : kRanks) {
    const std::vector<fs::path> files = source_files(folder);
    EXPECT_FALSE(files.empty()) << folder;
    for (const fs::path& file : files) {
      std::ifstream stream(file);
      for (const std::string& include : upward_includes(stream, folder))
        ADD_FAILURE() << file << " includes " << include;
    }
  }
}

TEST(Includes, ScenesKnowNoOpenGl) {
  static const std::regex kGl(R"(#\s*include\s*[<"](epoxy|GL|EGL|GLFW|imgui)[/.])");
  for (const fs::path& file : source_files("scenes")) {
    std::ifstream stream(file);
    for (std::string line; std::getline(stream, line);)
      EXPECT_FALSE(std::regex_search(line, kGl)) << file << ": " << line;
  }
}

TEST(Files, AreNotOver700Lines) {
  for (const std::string folder : {"scenes", "render", "ui", "viewer", "shaders", "tests"}) {
    for (const fs::path& file : source_files(folder)) {
      std::ifstream stream(file);
      int lines = 0;
      for (std::string line; std::getline(stream, line);) ++lines;
      EXPECT_LE(lines, 700) << file;
    }
  }
}

}  // namespace
