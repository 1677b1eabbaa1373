#pragma once

#include <string>

namespace maquette {

/// A file name, without a folder and an ending, for anything that has a name: letters, digits, `-` and `_` stay, so
/// that it is the same in a URL. A name that has others, or is empty or long, ends with its hash: different names have
/// different files.
std::string file_name_of(const std::string& name);
/// The same for a file that a person looks for: spaces and other scripts stay, and all but what no file name can hold.
std::string readable_file_name(const std::string& name);

}  // namespace maquette
