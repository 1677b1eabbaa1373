#pragma once

#include <string>
#include <vector>

namespace maquette {

/// A folder whose files are offered: scenes, reviews, paths, environments, materials.
struct FileBrowser {
  std::string folder;                ///< absolute; empty: not read yet
  std::vector<std::string> folders;  ///< names, sorted, hidden ones left out
  std::vector<std::string> files;    ///< the same, of kinds that can be opened
};

bool can_be_opened(const std::string& file);
/// Reads a folder; one that cannot be read has nothing in it.
FileBrowser browse_folder(const std::string& folder);

}  // namespace maquette
