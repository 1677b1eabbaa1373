#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace maquette {

/// What a JSON library's exception says, for people: without its own number, and without what it had read, which may be
/// a whole file.
inline std::string json_fault(std::string message) {
  constexpr std::size_t kLongest = 160;
  message.resize(std::min(message.find("; last read"), message.size()));
  const std::size_t number = message.find("] ");
  if (message.starts_with("[") && number != std::string::npos) message.erase(0, number + 2);
  return message.size() > kLongest ? message.substr(0, kLongest) + " ..." : message;
}

/// Values take sixteen bytes and more as a tree, eight times their text: such a document is refused before it is
/// parsed.
inline bool has_too_many_values(std::string_view text) {
  constexpr std::ptrdiff_t kMostValues = 20'000'000;
  return std::count(text.begin(), text.end(), ',') > kMostValues;
}

/// Such a document ends the stack of what walks, copies or writes it.
inline bool is_nested_deeper(std::string_view text, int most) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '{' || c == '[') {
      if (++depth > most) return true;
    } else if (c == '}' || c == ']') {
      --depth;
    }
  }
  return false;
}

}  // namespace maquette
