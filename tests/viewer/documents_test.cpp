// The documents keep their word: commands are ones that the program takes, scripts and linked files are there.
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <sstream>

#include "scenes/error.h"
#include "test_paths.h"
#include "tests/viewer/run_program.h"
#include "viewer/command_line.h"

namespace maquette {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> documents() {
  const fs::path root = MAQUETTE_SOURCE_DIR;
  std::vector<fs::path> all;
  for (const char* name : {"README.md", "ARCHITECTURE.md", "CHANGELOG.md"}) all.push_back(root / name);
  for (const auto& entry : fs::recursive_directory_iterator(root / "docs"))
    if (entry.path().extension() == ".md") all.push_back(entry.path());
  return all;
}

/// Words as a shell divides them, up to a comment, a redirection or a pipe.
std::vector<std::string> shell_words(const std::string& line) {
  std::vector<std::string> words;
  std::string word;
  bool begun = false;
  char quote = 0;
  for (const char c : line) {
    if (quote != 0) {
      if (c == quote)
        quote = 0;
      else
        word += c;
    } else if (c == '\'' || c == '"') {
      quote = c;
      begun = true;
    } else if (c == ' ') {
      if (begun || !word.empty()) words.push_back(word);
      word.clear();
      begun = false;
    } else if (word.empty() && (c == '#' || c == '>' || c == '|')) {
      return words;
    } else {
      word += c;
    }
  }
  if (begun || !word.empty()) words.push_back(word);
  return words;
}

/// Commands of blocks, without what explains them after several spaces, and those within a line.
std::vector<std::string> commands_of(const std::string& text) {
  std::vector<std::string> commands;
  static const std::regex kInLine("`(maquette [^`]*)`"), kBlock("^    (?:\\./build/)?(maquette(?: .*)?)$");
  std::string joined;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!joined.empty()) line = joined + line.substr(line.find_first_not_of(' '));
    joined.clear();
    if (line.ends_with("\\")) {
      joined = line.substr(0, line.size() - 1);
      continue;
    }
    std::smatch match;
    if (std::regex_match(line, match, kBlock)) {
      std::string command = match[1];
      if (const std::size_t gap = command.find("   "); gap != std::string::npos) command.resize(gap);
      commands.push_back(command);
    }
    for (std::sregex_iterator it(line.begin(), line.end(), kInLine), end; it != end; ++it) commands.push_back((*it)[1]);
  }
  return commands;
}

/// Whether it is the form of a command (`maquette bake KIND [SCENE]`) and not one that can be typed.
bool is_form(const std::string& command) {
  return std::regex_search(command, std::regex("[\\[\\]|]|[ =][A-Z]+( |$)| \\.\\.\\.")) ||
         command.find(' ') == command.rfind(' ');
}

TEST(Documents, CommandsAreOnesThatTheProgramTakes) {
  int checked = 0;
  for (const fs::path& document : documents()) {
    for (const std::string& command : commands_of(read_text(document.string()))) {
      if (is_form(command) && command != "maquette") continue;
      std::vector<std::string> words = shell_words(command);
      words.erase(words.begin());
      ++checked;
      EXPECT_NO_THROW(
          try { parse_command_line(words); } catch (const Error& error) {
            ADD_FAILURE() << document.filename().string() << ": " << command << ": " << error.what();
          })
          << command;
    }
  }
  EXPECT_GT(checked, 40);
}

TEST(Documents, ScriptsAndLinkedFilesAreThere) {
  const std::regex link("\\]\\(([^)#:]+)(#[^)]*)?\\)"), script("\\b(scripts/[a-z-]+(\\.[a-z]+)?)\\b");
  for (const fs::path& document : documents()) {
    const std::string text = read_text(document.string());
    for (std::sregex_iterator it(text.begin(), text.end(), link), end; it != end; ++it)
      EXPECT_TRUE(fs::exists(document.parent_path() / (*it)[1].str())) << document << ": " << (*it)[1];
    for (std::sregex_iterator it(text.begin(), text.end(), script), end; it != end; ++it)
      EXPECT_TRUE(fs::exists(fs::path(MAQUETTE_SOURCE_DIR) / (*it)[1].str())) << document << ": " << (*it)[1];
  }
}

}  // namespace
}  // namespace maquette
