#include "scenes/exr_stream.h"

#include <cerrno>
#include <cstring>
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

}  // namespace maquette
