#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace maquette {

/// What a JSON library's exception says, for people: the place and the fault, without its own number, what it was
/// parsing, and what it had read, which may be a whole file.
inline std::string json_fault(std::string message) {
  constexpr std::size_t kLongest = 160;
  message.resize(std::min(message.find("; last read"), message.size()));
  const auto drop = [&](std::string_view begin, std::string_view end) {
    const std::size_t from = message.find(begin);
    const std::size_t to = from == std::string::npos ? from : message.find(end, from);
    if (to != std::string::npos) message.erase(from, to + end.size() - from);
  };
  if (message.starts_with("[")) drop("[", "] ");
  drop("parse error at ", "at ");
  drop("syntax error while parsing ", " - ");
  return message.size() > kLongest ? message.substr(0, kLongest) + " ..." : message;
}

/// Values take sixteen bytes and more as a tree, eight times their text, and objects of a scene up to a kilobyte: such
/// a document is refused before it is parsed.
inline bool has_too_many_values(std::string_view text, std::ptrdiff_t most_values = 20'000'000) {
  constexpr std::ptrdiff_t kMostObjects = 2'000'000;
  return std::count(text.begin(), text.end(), ',') > most_values ||
         std::count(text.begin(), text.end(), '{') > kMostObjects;
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
