#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace maquette {

struct ProgramResult {
  int exit_code = -1;  ///< 128 + signal when it crashed
  std::string out;
  std::string error;
};

/// Runs the real program with these arguments; `environment` overrides variables (an empty value unsets). Without a
/// display unless the environment names one.
ProgramResult run_maquette(const std::vector<std::string>& arguments,
                           const std::map<std::string, std::string>& environment = {});

/// The same for any program, in a working folder.
ProgramResult run_in_folder(const std::string& folder, const std::string& program,
                            const std::vector<std::string>& arguments,
                            const std::map<std::string, std::string>& environment = {});

/// A fresh folder below the system's temporary one, removed at the end.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string file(const std::string& name) const { return (path_ / name).string(); }
  const std::filesystem::path& path() const { return path_; }
  std::vector<std::string> names() const;  ///< of the entries, sorted

 private:
  std::filesystem::path path_;
};

std::string read_text(const std::string& path);

}  // namespace maquette
