// Functions of at most 80 lines and files of at most 500: what is longer than a screen or two is not read but searched.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "test_paths.h"

namespace {

namespace fs = std::filesystem;

constexpr int kFunctionLines = 80, kFileLines = 500;

/// Longer ones that are still to be split: "file" or "file: function", and how long they may be.
const std::map<std::string, int> kExceptions = {
    // Each is one loop, whose parts share a dozen variables.
    {"shaders/bandwidth/mark.comp: main", 120},
    {"shaders/shared/octree.glsl: octree_trace", 101},
};

struct Function {
  std::string name;
  int first_line = 0, lines = 0;
};

/// `text` without comments, preprocessor lines and what stands in quotes; line breaks stay.
std::string bare_code(const std::string& text) {
  std::string code;
  bool begins = true;  // nothing but spaces on this line so far
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const auto skip_to = [&](const std::string& end) {
      const std::size_t from = i, stop = std::min(text.find(end, i + 1), text.size() - 1);
      for (std::size_t k = from; k <= stop; ++k)
        if (text[k] == '\n') code += '\n';
      i = std::min(stop + end.size() - 1, text.size() - 1);
    };
    if (begins && c == '#') {
      while (i + 1 < text.size() && (text[i + 1] != '\n' || text[i] == '\\'))
        if (text[++i] == '\n') code += '\n';
    } else if (c == '/' && i + 1 < text.size() && text[i + 1] == '/') {
      while (i + 1 < text.size() && text[i + 1] != '\n') ++i;
    } else if (c == '/' && i + 1 < text.size() && text[i + 1] == '*') {
      skip_to("*/");
    } else if (c == 'R' && i + 1 < text.size() && text[i + 1] == '"') {
      const std::size_t open = text.find('(', i);
      skip_to(")" + text.substr(i + 2, open - i - 2) + "\"");
      code += "0";
    } else if (c == '"' || (c == '\'' && (i == 0 || !std::isalnum(static_cast<unsigned char>(text[i - 1]))))) {
      for (++i; i < text.size() && text[i] != c; ++i)
        if (text[i] == '\\') ++i;
      code += "0";
    } else {
      code += c;
    }
    if (c == '\n' || !std::isspace(static_cast<unsigned char>(c))) begins = c == '\n';
  }
  return code;
}

/// Name of what `head` declares when a brace after it opens a function's body, else nothing.
std::string function_name(const std::string& head) {
  const std::size_t open = head.find('(');
  if (open == std::string::npos || open == 0) return {};
  std::size_t end = head.find_last_not_of(' ', open - 1) + 1, begin = end;
  while (begin > 0 && (std::isalnum(static_cast<unsigned char>(head[begin - 1])) || head[begin - 1] == '_' ||
                       head[begin - 1] == ':' || head[begin - 1] == '~'))
    --begin;
  const std::string name = head.substr(begin, end - begin);
  return name.starts_with("TEST") ? head.substr(begin, head.find(')') + 1 - begin) : name;
}

/// Every function at the level of a file, a namespace or a class, its head included. Expects clang-format's layout: a
/// function that begins in the first column ends with a brace in the first column.
std::vector<Function> functions_of(const std::string& text) {
  std::vector<Function> found;
  std::string head;
  Function open;
  int line = 1, depth = 0, head_line = 1;  // depth: of braces within the open function
  bool in_first_column = false, begins = true;
  for (const char c : bare_code(text)) {
    if (depth > 0) {
      if (c == '{') ++depth;
      if (c == '}' && (--depth == 0 || (in_first_column && begins))) {
        depth = 0;
        open.lines = line - open.first_line + 1;
        found.push_back(open);
        head.clear();
      }
    } else if (c == '{' && !function_name(head).empty()) {
      open = {function_name(head), head_line, 0};
      depth = 1;
    } else if (c == ';' || c == '{' || c == '}') {
      head.clear();
    } else {
      if (head.empty() && !std::isspace(static_cast<unsigned char>(c))) {
        head_line = line;
        in_first_column = begins;
      }
      if (!head.empty() || !std::isspace(static_cast<unsigned char>(c))) head += c == '\n' ? ' ' : c;
    }
    begins = c == '\n';
    line += c == '\n' ? 1 : 0;
  }
  return found;
}

std::string read(const fs::path& path) {
  std::ifstream stream(path);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

/// Calls `look` with the path below the sources and the text of every C++ and GLSL file in `folders`.
template <class Look>
void each_source(const std::vector<std::string>& folders, const Look& look) {
  static const std::set<std::string> kKinds = {".cpp", ".h", ".glsl", ".comp", ".vert", ".frag"};
  for (const std::string& folder : folders)
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(fs::path(MAQUETTE_SOURCE_DIR) / folder))
      if (kKinds.contains(entry.path().extension().string()))
        look(fs::relative(entry.path(), MAQUETTE_SOURCE_DIR).string(), read(entry.path()));
}

int allowed(const std::string& what, int usual) {
  const auto exception = kExceptions.find(what);
  return exception == kExceptions.end() ? usual : exception->second;
}

TEST(Lengths, FunctionsAreCountedFromHeadToBrace) {
  const std::vector<Function> found = functions_of(
      "namespace a {\n"
      "struct S {\n"
      "  int member(int x) const {  // }\n"
      "    return x;\n"
      "  }\n"
      "};\n"
      "const char* const kText = \"{\";\n"
      "void Class::two(int a,\n"
      "                int b) {\n"
      "#if A\n"
      "  if (a) {\n"
      "#else\n"
      "  if (b) {\n"
      "#endif\n"
      "  }\n"
      "}\n"
      "TEST(Group, Case) {\n"
      "}\n"
      "}  // namespace a\n");
  ASSERT_EQ(found.size(), 3u);
  EXPECT_EQ(found[0].name, "member");
  EXPECT_EQ(found[0].lines, 3);
  EXPECT_EQ(found[1].name, "Class::two");
  EXPECT_EQ(found[1].first_line, 8);
  EXPECT_EQ(found[1].lines, 9);
  EXPECT_EQ(found[2].name, "TEST(Group, Case)");
}

TEST(Lengths, FunctionsHaveAtMost80Lines) {
  std::size_t count = 0;
  each_source({"scenes", "render", "review", "ui", "viewer", "shaders"}, [&](const std::string& path,
                                                                             const std::string& text) {
    for (const Function& f : functions_of(text)) {
      ++count;
      EXPECT_LE(f.lines, allowed(path + ": " + f.name, kFunctionLines)) << path << ':' << f.first_line << ' ' << f.name;
    }
  });
  EXPECT_GT(count, 2000u) << "the count has lost functions";
}

TEST(Lengths, FilesHaveAtMost500Lines) {
  each_source({"scenes", "render", "review", "ui", "viewer", "shaders", "tests"},
              [](const std::string& path, const std::string& text) {
                EXPECT_LE(std::count(text.begin(), text.end(), '\n'), allowed(path, kFileLines)) << path;
              });
}

/// An exception that is no longer needed goes.
TEST(Lengths, EveryExceptionIsNeeded) {
  std::set<std::string> needed;
  each_source({"scenes", "render", "review", "ui", "viewer", "shaders", "tests"},
              [&](const std::string& path, const std::string& text) {
                if (std::count(text.begin(), text.end(), '\n') > kFileLines) needed.insert(path);
                for (const Function& f : functions_of(text))
                  if (f.lines > kFunctionLines) needed.insert(path + ": " + f.name);
              });
  for (const auto& [what, lines] : kExceptions) EXPECT_TRUE(needed.contains(what)) << what;
}

}  // namespace
