#include "viewer/outputs.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <span>
#include <vector>

#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/harmless.h"
#include "scenes/image_io.h"
#include "viewer/print.h"

namespace maquette {

PictureFormat picture_format(const std::string& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".exr") return PictureFormat::exr;
  if (extension == ".png") return PictureFormat::png;
  throw UsageError("--output " + path, "the name must end in .exr (linear) or .png (tone mapped)");
}

void check_writable(const std::string& option, const std::string& path) {
  if (path == "-") return;
  const std::string where = option + " " + path;
  std::error_code error;
  if (access(path.c_str(), F_OK) != 0 && errno == ENAMETOOLONG)
    throw Error(where, "this name is too long", "choose a shorter one");
  if (std::filesystem::is_directory(path, error)) throw Error(where, "this is a folder", "give a file name");
  if (is_written_through(path)) {
    if (access(path.c_str(), W_OK) != 0)
      throw Error(where, std::string("cannot be written: ") + std::strerror(errno), "choose another path");
    return;
  }
  const std::filesystem::path folder = std::filesystem::absolute(link_target(path)).parent_path();
  if (!std::filesystem::is_directory(folder, error))
    throw Error(where, "there is no folder " + folder.string(), "make it first");
  std::string probe = (folder / ".maquette-XXXXXX").string();
  const int file = mkstemp(probe.data());
  if (file < 0) throw Error(where, std::string("cannot be written: ") + std::strerror(errno), "choose another path");
  close(file);
  std::remove(probe.c_str());
}

std::vector<std::string> input_files(const SceneOptions& options) {
  std::vector<std::string> files{options.scene, options.environment, options.reference};
  for (const auto& [name, source] : options.materials) files.push_back(source);
  return files;
}

void check_replaces_none(const std::string& option, const std::string& path, const std::vector<std::string>& others) {
  const auto is_file = [](const std::string& name) {
    return !name.empty() && name != "-" && !name.starts_with("builtin:");
  };
  if (!is_file(path)) return;
  std::error_code error;  // what cannot be resolved is no file that could be lost
  const std::filesystem::path own = std::filesystem::weakly_canonical(path, error);
  for (const std::string& other : others)
    if (is_file(other) && std::filesystem::weakly_canonical(other, error) == own && !own.empty())
      throw UsageError(option + " " + path,
                       "it would replace " + other + ", which this command reads or writes; choose another name");
}

void check_picture_outputs(const SceneOptions& options, std::vector<std::string> inputs) {
  check_replaces_none("--output", options.output, inputs);
  inputs.push_back(options.output);
  check_replaces_none("--stats", options.stats, inputs);
  if (!options.output.empty()) {
    picture_format(options.output);
    check_writable("--output", options.output);
  }
  if (!options.stats.empty()) check_writable("--stats", options.stats);
}

void prepare_folder(const std::string& option, const std::string& folder) {
  const std::string where = option + " " + folder;
  std::error_code error;
  if (std::filesystem::exists(folder, error) && !std::filesystem::is_directory(folder, error))
    throw Error(where, "this is a file", "give the name of a folder");
  std::filesystem::create_directories(folder, error);
  if (error) throw Error(where, "the folder cannot be made: " + error.message(), "choose another path");
  check_writable(option, (std::filesystem::path(folder) / "a file").string());
}

Image load_picture(const std::string& path) {
  std::vector<std::string> warnings;
  Image image = load_hdr_image(path, &warnings);
  print_warnings(path, warnings);
  return image;
}

void write_text(const std::string& path, const std::string& text) {
  if (path == "-") {
    std::fputs(harmless_json(text).c_str(), stdout);
    return;
  }
  write_file_atomically(path, std::as_bytes(std::span(text.data(), text.size())));
}

}  // namespace maquette
