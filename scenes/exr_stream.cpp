#include "scenes/exr_stream.h"

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <stdexcept>

namespace maquette {

ExrStream::ExrStream(const std::string& path) : Imf::OStream(path.c_str()), stream_(path, std::ios::binary) {
  if (!stream_) throw std::runtime_error(std::strerror(errno));
}

void ExrStream::write(const char bytes[], int count) {
  stream_.write(bytes, count);
  if (stream_) return;
  if (error_ == 0) error_ = errno != 0 ? errno : EIO;
  throw std::runtime_error(std::strerror(error_));
}

std::uint64_t ExrStream::tellp() { return static_cast<std::uint64_t>(static_cast<std::streamoff>(stream_.tellp())); }

void ExrStream::seekp(std::uint64_t position) { stream_.seekp(static_cast<std::streamoff>(position)); }

void ExrStream::close() {
  stream_.close();
  if (error_ == 0 && !stream_) error_ = errno != 0 ? errno : EIO;
  if (error_ != 0) throw std::runtime_error(std::strerror(error_));
}

namespace {

/// Bytes that OpenEXR reads of an attribute of this type, whatever the header says; 0: as many as it says.
std::int64_t bytes_of_type(const std::string& type) {
  static const std::map<std::string, std::int64_t> kBytes = {{"box2f", 16},
                                                             {"box2i", 16},
                                                             {"chromaticities", 32},
                                                             {"compression", 1},
                                                             {"deepImageState", 1},
                                                             {"double", 8},
                                                             {"envmap", 1},
                                                             {"float", 4},
                                                             {"int", 4},
                                                             {"keycode", 28},
                                                             {"lineOrder", 1},
                                                             {"m33d", 72},
                                                             {"m33f", 36},
                                                             {"m44d", 128},
                                                             {"m44f", 64},
                                                             {"rational", 8},
                                                             {"tiledesc", 9},
                                                             {"timecode", 8},
                                                             {"v2d", 16},
                                                             {"v2f", 8},
                                                             {"v2i", 8},
                                                             {"v3d", 24},
                                                             {"v3f", 12},
                                                             {"v3i", 12}};
  const auto found = kBytes.find(type);
  return found == kBytes.end() ? 0 : found->second;
}

/// Whether the bytes are a list of channels to their end: a name and 16 bytes each, then an empty name.
bool is_channel_list(const std::string& bytes) {
  constexpr std::size_t kBytesOfChannel = 16;
  std::size_t at = 0;
  while (at < bytes.size() && bytes[at] != '\0') {
    const std::size_t end = bytes.find('\0', at);
    if (end == std::string::npos) return false;
    at = end + 1 + kBytesOfChannel;
  }
  return at + 1 == bytes.size();
}

/// Whether the bytes are a picture of the size that they begin with, four bytes a pixel.
bool is_preview(const std::string& bytes) {
  std::uint32_t size[2] = {};
  if (bytes.size() < sizeof size) return false;
  std::memcpy(size, bytes.data(), sizeof size);
  return std::uint64_t{size[0]} * size[1] == (bytes.size() - sizeof size) / 4;
}

}  // namespace

const char* checked_exr(const std::string& path) {
  constexpr char kMagic[] = {'\x76', '\x2f', '\x31', '\x01'};
  constexpr unsigned char kMultiPart = 0x10;  // in the second byte of version and flags
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff bytes = file.tellg();
  file.seekg(0);
  char begin[8] = {};
  if (!file.read(begin, sizeof begin) || std::memcmp(begin, kMagic, sizeof kMagic) != 0) return path.c_str();
  const bool many = (static_cast<unsigned char>(begin[5]) & kMultiPart) != 0;
  std::string name, type, value;
  for (bool first = true; std::getline(file, name, '\0'); first = false) {
    if (name.empty()) {  // the end of a header; another one follows, or the end of all
      if (!many || first || file.peek() == 0) break;
      continue;
    }
    unsigned char size[4] = {};
    if (!std::getline(file, type, '\0') || !file.read(reinterpret_cast<char*>(size), sizeof size)) break;
    const std::int64_t length = size[0] | size[1] << 8 | size[2] << 16 | std::int64_t{size[3]} << 24;
    const std::string what = "the attribute " + name.substr(0, 64);
    if (length > bytes - file.tellg()) throw std::runtime_error(what + " says that it is longer than the file");
    value.resize(static_cast<std::size_t>(length));
    file.read(value.data(), length);
    const std::int64_t known = bytes_of_type(type);
    if ((known != 0 && known != length) || (type == "chlist" && !is_channel_list(value)) ||
        (type == "preview" && !is_preview(value)))
      throw std::runtime_error(what + " does not have the length of its type");
  }
  return path.c_str();
}

bool can_hold(const std::string& path, std::uintmax_t bytes) {
  constexpr std::uintmax_t kMostCompression = 1040;
  std::error_code code;
  const std::uintmax_t size = std::filesystem::file_size(path, code);
  return !code && bytes / kMostCompression <= size;
}

}  // namespace maquette
