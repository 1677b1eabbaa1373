#include "scenes/file_name.h"

#include <algorithm>
#include <cctype>
#include <cstdio>

#include "scenes/files.h"

namespace maquette {

namespace {

constexpr std::size_t kLongest = 100;

/// At most `kLongest` bytes, and no part of a letter of UTF-8.
std::string shortened(const std::string& name) {
  std::size_t end = std::min(name.size(), kLongest);
  while (end > 0 && end < name.size() && (static_cast<unsigned char>(name[end]) & 0xc0u) == 0x80u) --end;
  return name.substr(0, end);
}

template <typename Stays>
std::string with_hash_of_others(const std::string& name, const Stays& stays) {
  std::string file = shortened(name);
  bool same = !name.empty() && file.size() == name.size();
  for (char& c : file) {
    if (stays(static_cast<unsigned char>(c))) continue;
    c = '-';
    same = false;
  }
  if (same) return file;
  char hash[16];
  const std::uint64_t content = content_hash(std::as_bytes(std::span(name)));
  std::snprintf(hash, sizeof hash, "-%08x", static_cast<unsigned>(content & 0xffffffffu));
  return file + hash;
}

}  // namespace

std::string file_name_of(const std::string& name) {
  return with_hash_of_others(name,
                             [](unsigned char c) { return c < 128 && (std::isalnum(c) || c == '-' || c == '_'); });
}

std::string readable_file_name(const std::string& name) {
  const std::string file = with_hash_of_others(name, [](unsigned char c) { return c >= 32 && c != 127 && c != '/'; });
  return file.starts_with(".") ? "-" + file : file;
}

}  // namespace maquette
