#pragma once

#include <string>
#include <vector>

#include "scenes/image.h"
#include "viewer/options.h"

namespace maquette {

enum class PictureFormat { exr, png };

/// By the extension of `path`. Throws UsageError for any other.
PictureFormat picture_format(const std::string& path);

/// Throws Error when a file cannot be written at `path`; tests this by creating and removing another file in its
/// folder. Called before the work, so that no result is lost. "-" is standard output.
void check_writable(const std::string& option, const std::string& path);

/// What the options name to be read, built-in things among them.
std::vector<std::string> input_files(const SceneOptions& options);

/// Throws UsageError where `path` is one of `others`: what the command reads, and what else it writes. Names that are
/// no file (empty, "-", built in) are none of them.
void check_replaces_none(const std::string& option, const std::string& path, const std::vector<std::string>& others);

/// Before the work: --output and --stats of a picture replace none of `inputs`, nor each other, and can be written.
/// Throws Error.
void check_picture_outputs(const SceneOptions& options, std::vector<std::string> inputs);

/// Makes `folder` where it is not there yet. Throws Error when it cannot be made or written into.
void prepare_folder(const std::string& option, const std::string& folder);

/// Loads a picture to compare with; what could not be followed goes to standard error. Throws Error.
Image load_picture(const std::string& path);

/// Writes text atomically; "-" prints it.
void write_text(const std::string& path, const std::string& text);

}  // namespace maquette
