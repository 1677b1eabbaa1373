#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include "render/technique/registry.h"
#include "test_paths.h"

namespace {

namespace fs = std::filesystem;

const std::map<std::string, int> kRanks = {{"scenes", 0}, {"render", 1}, {"review", 2}, {"ui", 3}, {"viewer", 4}};

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
  std::istringstream text("#include \"scenes/scene.h\"\n#include \"render/frame/plan.h\"\n");
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

/// Passes of a frame know only their own resources and what they are handed.
TEST(Includes, NoPassKnowsAnotherNorTheRenderer) {
  const std::vector<std::string> passes = {"render/gbuffer/raster",
                                           "render/gbuffer/surfaces",
                                           "render/bandwidth/prediction",
                                           "render/bandwidth/upsampling",
                                           "render/bandwidth/accumulation",
                                           "render/bandwidth/temporal_reuse",
                                           "render/bandwidth/swapped_tables",
                                           "render/indirect/indirect_pass",
                                           "render/picture/composer",
                                           "render/picture/presenter",
                                           "render/glass/panes",
                                           "render/glossy/glossy",
                                           "render/reflections/reflections"};
  for (const std::string& pass : passes)
    for (const char* extension : {".h", ".cpp"}) {
      std::ifstream stream(fs::path(MAQUETTE_SOURCE_DIR) / (pass + extension));
      ASSERT_TRUE(stream) << pass << extension;
      for (std::string line; std::getline(stream, line);) {
        if (line.rfind("#include", 0) != 0) continue;
        EXPECT_EQ(line.find("render/renderer"), std::string::npos) << pass << extension << ": " << line;
        for (const std::string& other : passes)
          EXPECT_TRUE(other == pass || line.find("\"" + other + ".h\"") == std::string::npos)
              << pass << extension << ": " << line;
      }
    }
}

/// Core, panels and commands ask techniques for what they can do: their names stand in their own folders and in the
/// registry only.
TEST(Names, OfTechniquesStandInTheirFoldersOnly) {
  const maquette::Registry& registry = maquette::builtin_registry();
  std::vector<std::string> names;
  for (const maquette::Technique& technique : registry.techniques)
    if (technique.kind != maquette::TechniqueKind::shared) names.push_back(technique.name);
  ASSERT_GE(names.size(), 9u);
  for (const std::string folder : {"render", "review", "ui", "viewer"}) {
    for (const fs::path& file : source_files(folder)) {
      const std::string path = fs::relative(file, MAQUETTE_SOURCE_DIR).string();
      // Two words of plan and stats, which are a contract, are spelled like techniques.
      if (path == "render/technique/registry.cpp" || path == "render/frame/vocabulary.h") continue;
      std::ifstream stream(file);
      int number = 0;
      for (std::string line; std::getline(stream, line);) {
        ++number;
        for (const std::string& name : names) {
          if (line.find("\"" + name + "\"") == std::string::npos || path.rfind("render/" + name + "/", 0) == 0)
            continue;
          // A key of --stats, which is a contract, and a column of a bake are no techniques.
          const bool is_key = line.find("json[\"" + name + "\"]") != std::string::npos ||
                              line.find("bytes)[\"" + name + "\"]") != std::string::npos ||
                              (path == "render/octree/octree_file.cpp" && line.find(".integers") != std::string::npos);
          EXPECT_TRUE(is_key) << path << ":" << number << ": " << line;
        }
      }
    }
  }
}

}  // namespace
