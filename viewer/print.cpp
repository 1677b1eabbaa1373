#include "viewer/print.h"

#include <cstdarg>

#include "scenes/harmless.h"

namespace maquette {

namespace {

constexpr std::size_t kLongestLine = 1000;
constexpr std::size_t kMostWarnings = 3;

void put_line(std::FILE* stream, const std::string& text) {
  std::fputs((harmless(without_middle(text, kLongestLine)) + "\n").c_str(), stream);
}

}  // namespace

void print_line(std::FILE* stream, const char* format, ...) {
  std::va_list arguments, again;
  va_start(arguments, format);
  va_copy(again, arguments);
  const int length = std::vsnprintf(nullptr, 0, format, arguments);
  va_end(arguments);
  std::string text(static_cast<std::size_t>(length > 0 ? length : 0) + 1, '\0');
  std::vsnprintf(text.data(), text.size(), format, again);
  va_end(again);
  text.pop_back();
  if (text.ends_with('\n')) text.pop_back();
  put_line(stream, text);
}

void print_warnings(const std::string& where, const std::vector<std::string>& warnings) {
  const std::string before = where.empty() ? "" : where + ": ";
  const std::size_t shown = warnings.size() > kMostWarnings ? 1 : warnings.size();
  for (std::size_t i = 0; i < shown; ++i) put_line(stderr, "warning: " + before + warnings[i]);
  if (shown < warnings.size())
    print_line(stderr, "warning: %s%zu more warnings; maquette inspect lists them", before.c_str(),
               warnings.size() - shown);
}

void print_text(std::FILE* stream, const std::string& text) { std::fputs(harmless(text, true).c_str(), stream); }

}  // namespace maquette
