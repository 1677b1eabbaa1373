#include "scenes/harmless.h"

#include <cstdint>
#include <cstdio>

namespace maquette {

namespace {

/// Source: Unicode 15, Sec. 23.1, 23.2 and 23.9: control codes, line and paragraph separators, bidirectional controls;
/// the byte order mark; tags, which nobody sees.
bool steers(std::uint32_t c) {
  return c < 32u || (c >= 0x7fu && c < 0xa0u) || c == 0x61cu || c == 0x200eu || c == 0x200fu ||
         (c >= 0x2028u && c <= 0x202eu) || (c >= 0x2066u && c <= 0x2069u) || c == 0xfeffu ||
         (c >= 0xe0000u && c < 0xe0080u);
}

/// What stands for bytes that are no UTF-8, and how it begins.
constexpr std::uint32_t kPrivateCode = 0x10ff00u;
const std::string kPrivate = "\xf4\x8f";

std::string byte_escape(unsigned byte) {
  char text[8];
  std::snprintf(text, sizeof text, "\\x%02x", byte & 255u);
  return text;
}

std::string code_escape(std::uint32_t code) {
  char text[16];
  std::snprintf(text, sizeof text, "\\u%04x", code);
  return text;
}

}  // namespace

Utf8Character utf8_character(const std::string& text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const std::uint32_t first = byte(at);
  if (first < 0x80u) return {first, 1};
  const std::size_t bytes = first >= 0xf0u ? 4 : first >= 0xe0u ? 3 : 2;
  if (first < 0xc2u || first > 0xf4u) return {};
  std::uint32_t code = first & (0x7fu >> bytes);
  for (std::size_t i = 1; i < bytes; ++i) {
    if ((byte(at + i) & 0xc0u) != 0x80u) return {};
    code = code << 6u | (byte(at + i) & 0x3fu);
  }
  constexpr std::uint32_t kLeast[] = {0, 0, 0x80u, 0x800u, 0x10000u};
  if (code < kLeast[bytes] || code > 0x10ffffu || (code >= 0xd800u && code < 0xe000u)) return {};
  return {code, bytes};
}

std::string harmless(const std::string& text, bool lines) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const Utf8Character c = utf8_character(text, at);
    if (c.bytes == 0)
      out += byte_escape(static_cast<unsigned char>(text[at]));
    else if (steers(c.code) && !(lines && (c.code == '\n' || c.code == '\t')))
      out += c.code < 0x80u ? byte_escape(c.code) : code_escape(c.code);
    else
      out.append(text, at, c.bytes);
    at += c.bytes == 0 ? 1 : c.bytes;
  }
  return out;
}

std::string harmless_json(const std::string& document) {
  std::string out;
  for (std::size_t at = 0; at < document.size();) {
    const Utf8Character c = utf8_character(document, at);
    if (c.bytes == 0)
      out += "\\ufffd";
    else if (c.code > 0xffffu && steers(c.code))  // two halves. Source: RFC 8259, Sec. 7
      out += code_escape(0xd7c0u + (c.code >> 10u)) + code_escape(0xdc00u + (c.code & 0x3ffu));
    else if (c.code >= 0x7fu && steers(c.code))
      out += code_escape(c.code);
    else
      out.append(document, at, c.bytes);
    at += c.bytes == 0 ? 1 : c.bytes;
  }
  return out;
}

std::string without_middle(const std::string& text, std::size_t most) {
  if (text.size() <= most) return text;
  return text.substr(0, most / 2) + " ... " + text.substr(text.size() - most / 2);
}

std::string as_utf8(const std::string& name) {
  std::string out;
  for (std::size_t at = 0; at < name.size();) {
    const Utf8Character c = utf8_character(name, at);
    if (c.bytes == 0) {
      const unsigned byte = static_cast<unsigned char>(name[at]);
      out += kPrivate;
      out += static_cast<char>(0xbcu | byte >> 6u);
      out += static_cast<char>(0x80u | (byte & 0x3fu));
    } else {
      out.append(name, at, c.bytes);
    }
    at += c.bytes == 0 ? 1 : c.bytes;
  }
  return out;
}

std::string from_utf8(const std::string& text) {
  std::string out = text;
  for (std::size_t at = 0; (at = out.find(kPrivate, at)) != std::string::npos; ++at) {
    const Utf8Character c = utf8_character(out, at);
    if (c.code >= kPrivateCode) out.replace(at, c.bytes, 1, static_cast<char>(c.code & 255u));
  }
  return out;
}

}  // namespace maquette
