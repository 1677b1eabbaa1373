#include <algorithm>
#include <cctype>
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/gltf_file.h"

namespace maquette::gltf {
namespace {

constexpr std::string_view kDataScheme = "data:";
constexpr std::string_view kBase64 = ";base64";

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

/// A percent sign that starts no escape stays one.
std::string percent_decode(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool escaped =
        text[i] == '%' && i + 2 < text.size() && hex_digit(text[i + 1]) >= 0 && hex_digit(text[i + 2]) >= 0;
    out.push_back(escaped ? static_cast<char>(hex_digit(text[i + 1]) * 16 + hex_digit(text[i + 2])) : text[i]);
    if (escaped) i += 2;
  }
  return out;
}

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+' || c == '-') return 62;
  if (c == '/' || c == '_') return 63;
  return -1;
}

bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

std::vector<std::byte> base64_decode(const std::string& where, std::string_view text) {
  std::vector<std::byte> out;
  out.reserve(text.size() / 4 * 3);
  std::uint32_t bits = 0;
  int bit_count = 0;
  for (const char c : text) {
    if (c == '=') break;
    if (is_space(c)) continue;  // some writers break their lines
    const int digit = base64_digit(c);
    if (digit < 0) throw Error(where, "its data URI is not valid base64", "export the file again");
    bits = bits << 6 | static_cast<std::uint32_t>(digit);
    bit_count += 6;
    if (bit_count >= 8) {
      bit_count -= 8;
      out.push_back(static_cast<std::byte>(bits >> bit_count & 0xff));
    }
  }
  return out;
}

bool equal_but_for_case(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
  });
}

/// The last parameter of `data:[type][;attribute=value]*[;base64]`; blanks around it are no part of it.
bool ends_in_base64(std::string header) {
  std::erase_if(header, is_space);
  return header.size() >= kBase64.size() &&
         equal_but_for_case(std::string_view(header).substr(header.size() - kBase64.size()), kBase64);
}

}  // namespace

bool is_data_uri(std::string_view uri) { return equal_but_for_case(uri.substr(0, kDataScheme.size()), kDataScheme); }

std::string media_type(std::string_view uri) {
  const std::string header = percent_decode(uri.substr(kDataScheme.size(), uri.find(',') - kDataScheme.size()));
  std::string type = header.substr(0, header.find(';'));
  std::erase_if(type, is_space);
  std::transform(type.begin(), type.end(), type.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return type;
}

/// Source: RFC 2397, section 3: base64 is itself a URI's text, so that it may be percent-encoded too.
std::vector<std::byte> decode_data_uri(const std::string& where, std::string_view uri) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos) throw Error(where, "its data URI has no comma", "export the file again");
  const std::string_view payload = uri.substr(comma + 1);
  const bool is_base64 = ends_in_base64(percent_decode(uri.substr(0, comma)));
  if (is_base64 && payload.find('%') == std::string_view::npos) return base64_decode(where, payload);
  const std::string text = percent_decode(payload);
  if (is_base64) return base64_decode(where, text);
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

/// Source: RFC 3986, sections 2.1 and 5.2.4. Writers that do not encode are common: where the decoded name is not
/// there, the text itself may be.
std::string resolve_uri(const std::string& path, std::string_view uri) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(path).parent_path();
  const std::string decoded = percent_decode(uri), raw(uri);
  if (decoded.find('\0') != std::string::npos) return (folder / raw).string();
  std::string slashed = decoded;
  std::replace(slashed.begin(), slashed.end(), '\\', '/');
  for (const fs::path& name :
       {fs::path(decoded), fs::path(decoded).lexically_normal(), fs::path(raw), fs::path(slashed)}) {
    std::error_code ignored;
    if (fs::exists(folder / name, ignored)) return (folder / name).string();
  }
  return (folder / decoded).string();
}

bool has_scheme(std::string_view uri) {
  // Source: RFC 3986, section 3.1.
  const std::size_t colon = uri.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789+-.");
  return colon != std::string_view::npos && colon > 1 && uri[colon] == ':';
}

std::vector<std::byte> read_uri(const std::string& path, std::string_view uri) {
  namespace fs = std::filesystem;
  const std::string file = resolve_uri(path, uri);
  std::error_code code;
  const fs::file_status status = fs::status(file, code);
  if (has_scheme(uri) && !fs::exists(status))
    throw Error("", name_text(uri) + " is not read: only files beside the scene are");
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status))
    throw Error(file, "is no regular file");
  return read_file(file);
}

}  // namespace maquette::gltf
