#pragma once

#include <cstdint>
#include <string>

namespace maquette {

/// Code and length of a character; length 0: the byte is no UTF-8.
struct Utf8Character {
  std::uint32_t code = 0;
  std::size_t bytes = 0;
};
/// The character that begins at a byte. Source: RFC 3629, Sec. 4.
Utf8Character utf8_character(const std::string& text, std::size_t at);

/// Text for a terminal. Names come from files: what would steer the terminal or hide what follows is written as an
/// escape: control characters (`\x1b`; with `lines` newlines and tabs stay), characters that turn the direction of
/// writing or end lines (`\u202e`), and bytes that are no UTF-8 (`\xff`).
std::string harmless(const std::string& text, bool lines = false);
/// The same of a JSON document, whose strings stay what they are: by JSON's own escapes.
std::string harmless_json(const std::string& document);

/// Without its middle where it has more than `most` bytes: a name may be as long as its file.
std::string without_middle(const std::string& text, std::size_t most);

/// A name for documents that must be UTF-8: of bytes that are none each becomes the private character U+10FF00 + byte.
std::string as_utf8(const std::string& name);
/// The name that as_utf8 made such a text of.
std::string from_utf8(const std::string& text);

}  // namespace maquette
