#include "scenes/gltf_file.h"

#include <cstdint>
#include <cstring>

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
  std::map<std::string, std::size_t> line_of;  // of an element by itself
  for (const Entry& entry : entries_) {
    std::string line = entry.where;
    if (!line.empty() && entry.count > 1) line += " and " + std::to_string(entry.count - 1) + " more";
    if (!line.empty() && entry.count == 1) {
      const auto [found, is_new] = line_of.emplace(line, lines.size());
      if (!is_new) {
        lines[found->second] += "; " + entry.what;
        continue;
      }
    }
    lines.push_back(line.empty() ? entry.what : line + ": " + entry.what);
  }
  return lines;
}

std::string name_text(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  if (is_data_uri(text)) return "a data URI";
  if (text.size() > kLongest) return "a text of " + std::to_string(text.size()) + " bytes";
  return "\"" + std::string(text) + "\"";
}

std::string name_node(const std::string& name, std::size_t index) {
  return name.empty() ? element("nodes", index) : "node " + name_text(name);
}

std::string plain_line(std::string_view text, std::string_view folder) {
  constexpr std::size_t kLongest = 200, kKept = 40;
  std::string out;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const auto is_blank = [](char c) { return static_cast<unsigned char>(c) <= ' ' || c == 127; };
    if (is_blank(text[begin])) {
      out.push_back(' ');
      ++begin;
      continue;
    }
    std::size_t end = begin;
    while (end < text.size() && !is_blank(text[end])) ++end;
    const std::string_view word = text.substr(begin, end - begin);
    // A payload begins a word or what is quoted; `metadata:` and folders are none.
    const std::size_t start = word.find_first_not_of("\"'(");
    const std::size_t payload =
        word.substr(std::min(start, word.size())).starts_with("data:") ? start : std::string_view::npos;
    if (payload != std::string_view::npos) {
      out.append(word.substr(0, payload)).append("data:...");
    } else if (const std::size_t usual = word.starts_with(folder) ? folder.size() : 0; word.size() > kLongest + usual) {
      out.append(word.substr(0, usual + kKept)).append("...");
    } else {
      out.append(word);
    }
    begin = end;
  }
  return out;
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

/// Without the byte order mark that RFC 8259 8.1 lets parsers ignore, and the padding by NUL that some writers use.
std::string_view json_text(Bytes bytes) {
  std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  while (text.ends_with('\0')) text.remove_suffix(1);
  return text;
}

}  // namespace

Container split_container(const std::string& path, Bytes file, Warnings* warnings) {
  Container container;
  if (file.size() < 4)
    throw Error(path, "is not a glTF file (" + std::to_string(file.size()) + " bytes)", "name a .gltf or .glb file");
  if (read_u32(file, 0) != kGlbMagic) {
    container.json = json_text(file);
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
    if (length - offset < kChunkHeaderBytes) {
      if (chunk == 0) throw Error(path, "GLB chunk header is cut short", remedy);
      warnings->add("bytes after the last chunk of the GLB are ignored");
      break;
    }
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
    if (chunk == 0) container.json = json_text(content);
    if (chunk > 0 && type == kBinaryChunk && container.binary.empty()) {
      if (chunk > 1) warnings->add("the binary chunk of the GLB is not its second");
      container.binary = content;
    }
    offset += size;
  }
  return container;
}

}  // namespace maquette::gltf
