#pragma once

#include <cstdio>
#include <string>
#include <vector>

namespace maquette {

/// One line to standard output or standard error, as printf has it: names in it cannot steer the terminal, nor make it
/// several lines (scenes/harmless.h).
[[gnu::format(printf, 2, 3)]] void print_line(std::FILE* stream, const char* format, ...);
/// Text of several lines, whose names cannot steer the terminal either.
void print_text(std::FILE* stream, const std::string& text);

/// A line for each warning of a file, `where: ` before it where that is not empty; of many the first one and how many
/// more there are.
void print_warnings(const std::string& where, const std::vector<std::string>& warnings);

}  // namespace maquette
