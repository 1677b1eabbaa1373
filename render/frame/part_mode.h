#pragma once

#include <string>
#include <vector>

namespace maquette {

/// A part of the scene that has a shading mode of its own (`--mode-of NODE=MODE`).
struct PartMode {
  std::string node;  ///< name, or path from a root: names joined by '/'
  std::string mode;
  int index = -1;  ///< of the one node that is meant; -1: those of that name or path
  bool operator==(const PartMode&) const = default;
};

}  // namespace maquette
