#pragma once

#include <OpenEXR/ImfIO.h>

#include <fstream>
#include <string>

namespace maquette {

/// A file that OpenEXR writes. OpenEXR's own files are finished in destructors, which swallow errors of the last bytes
/// and of the table of offsets: here they are kept for close().
class ExrStream final : public Imf::OStream {
 public:
  explicit ExrStream(const std::string& path);
  void write(const char bytes[], int count) override;
  std::uint64_t tellp() override;
  void seekp(std::uint64_t position) override;
  /// Once the OutputFile is gone. Throws std::runtime_error where anything was not written.
  void close();

 private:
  std::ofstream stream_;
  int error_ = 0;  ///< errno of the first failure
};

/// The path again, once no attribute of a header says that it is longer than the file: OpenEXR reserves that memory
/// before it reads. Attributes must have the length of their type, because OpenEXR goes by the type and would find the
/// next one elsewhere. What is no EXR file is left to OpenEXR. Throws std::runtime_error. Source: "OpenEXR File Layout".
const char* checked_exr(const std::string& path);

/// Whether a file compressed by zlib can hold so many bytes of values: memory is not reserved for more. Source: zlib's
/// technical details, "a limit of about 1030:1".
bool can_hold(const std::string& path, std::uintmax_t bytes);

}  // namespace maquette
