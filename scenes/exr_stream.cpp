#include "scenes/exr_stream.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
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

const char* checked_exr(const std::string& path) {
  constexpr char kMagic[] = {'\x76', '\x2f', '\x31', '\x01'};
  constexpr unsigned char kMultiPart = 0x10;  // in the second byte of version and flags
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff bytes = file.tellg();
  file.seekg(0);
  char begin[8] = {};
  if (!file.read(begin, sizeof begin) || std::memcmp(begin, kMagic, sizeof kMagic) != 0) return path.c_str();
  const bool many = (static_cast<unsigned char>(begin[5]) & kMultiPart) != 0;
  std::string name, type;
  for (bool first = true; std::getline(file, name, '\0'); first = false) {
    if (name.empty()) {  // the end of a header; another one follows, or the end of all
      if (!many || first || file.peek() == 0) break;
      continue;
    }
    unsigned char size[4] = {};
    if (!std::getline(file, type, '\0') || !file.read(reinterpret_cast<char*>(size), sizeof size)) break;
    const std::int64_t length = size[0] | size[1] << 8 | size[2] << 16 | std::int64_t{size[3]} << 24;
    if (length > bytes - file.tellg())
      throw std::runtime_error("the attribute " + name.substr(0, 64) + " says that it is longer than the file");
    file.seekg(length, std::ios::cur);
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
