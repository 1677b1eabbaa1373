#include "scenes/gltf_file.h"

#include <cstdint>
#include <cstring>
#include <filesystem>

#include "scenes/error.h"

namespace maquette::gltf {

std::string at(const std::string& path, const std::string& element) { return path + ": " + element; }

std::string element(const char* array, std::size_t index) {
  return std::string(array) + "[" + std::to_string(index) + "]";
}

void Warnings::add(const std::string& what, const std::string& where) {
  const auto [found, is_new] = index_.try_emplace(what, entries_.size());
  if (is_new) entries_.push_back({what, where, 0});
  ++entries_[found->second].count;
}

void Warnings::merge(const Warnings& other) {
  for (const Entry& entry : other.entries_) {
    add(entry.what, entry.where);
    entries_[index_[entry.what]].count += entry.count - 1;
  }
}

std::vector<std::string> Warnings::lines() const {
  std::vector<std::string> lines;
  for (const Entry& entry : entries_) {
    std::string line = entry.where;
    if (!line.empty() && entry.count > 1) line += " and " + std::to_string(entry.count - 1) + " more";
    lines.push_back(line.empty() ? entry.what : line + ": " + entry.what);
  }
  return lines;
}

namespace {

constexpr std::uint32_t kGlbMagic = 0x46546C67;   // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;  // "JSON"
constexpr std::uint32_t kBinaryChunk = 0x004E4942;
constexpr std::size_t kGlbHeaderBytes = 12;
constexpr std::size_t kChunkHeaderBytes = 8;

std::uint32_t read_u32(Bytes bytes, std::size_t offset) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + offset, sizeof(value));
  return value;
}

std::string_view as_text(Bytes bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::string percent_decode(std::string_view text) {
  std::string out;
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

std::vector<std::byte> base64_decode(const std::string& where, std::string_view text) {
  std::vector<std::byte> out;
  out.reserve(text.size() / 4 * 3);
  std::uint32_t bits = 0;
  int bit_count = 0;
  for (const char c : text) {
    if (c == '=') break;
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

}  // namespace

Container split_container(const std::string& path, Bytes file, Warnings* warnings) {
  Container container;
  if (file.size() < 4)
    throw Error(path, "is not a glTF file (" + std::to_string(file.size()) + " bytes)", "name a .gltf or .glb file");
  if (read_u32(file, 0) != kGlbMagic) {
    container.json = as_text(file);
    return container;
  }
  container.is_binary = true;
  const std::string remedy = "the file is truncated or damaged; copy or export it again";
  if (file.size() < kGlbHeaderBytes + kChunkHeaderBytes) throw Error(path, "GLB header is cut short", remedy);
  const std::uint32_t version = read_u32(file, 4);
  if (version != 2)
    throw Error(path, "is GLB version " + std::to_string(version) + ", expected 2", "export as glTF 2.0");
  const std::size_t length = read_u32(file, 8);
  if (length > file.size() || length < kGlbHeaderBytes + kChunkHeaderBytes)
    throw Error(path,
                "GLB header promises " + std::to_string(length) + " bytes, the file has " + std::to_string(file.size()),
                remedy);
  if (length < file.size()) warnings->add("bytes after the end of the GLB are ignored");

  std::size_t offset = kGlbHeaderBytes;
  for (int chunk = 0; offset < length; ++chunk) {
    if (length - offset < kChunkHeaderBytes) throw Error(path, "GLB chunk header is cut short", remedy);
    const std::size_t size = read_u32(file, offset);
    const std::uint32_t type = read_u32(file, offset + 4);
    offset += kChunkHeaderBytes;
    if (size > length - offset)
      throw Error(path,
                  "GLB chunk " + std::to_string(chunk) + " promises " + std::to_string(size) + " bytes, " +
                      std::to_string(length - offset) + " are left",
                  remedy);
    const Bytes content = file.subspan(offset, size);
    if (chunk == 0 && type != kJsonChunk) throw Error(path, "first GLB chunk is not JSON", remedy);
    if (chunk == 0) container.json = as_text(content);
    if (chunk == 1 && type == kBinaryChunk) container.binary = content;
    offset += size;
  }
  return container;
}

std::vector<std::byte> decode_data_uri(const std::string& where, std::string_view uri) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos) throw Error(where, "its data URI has no comma", "export the file again");
  const std::string_view payload = uri.substr(comma + 1);
  if (uri.substr(0, comma).ends_with(";base64")) return base64_decode(where, payload);
  const std::string text = percent_decode(payload);
  const auto* first = reinterpret_cast<const std::byte*>(text.data());
  return {first, first + text.size()};
}

std::string resolve_uri(const std::string& path, std::string_view uri) {
  return (std::filesystem::path(path).parent_path() / percent_decode(uri)).string();
}

}  // namespace maquette::gltf
