#pragma once

#include <string>
#include <vector>

namespace maquette {

/// A part of the scene that has a shading mode of its own (`--mode-of NODE=MODE`).
struct PartMode {
  std::string node;  ///< name, or path from a root: names joined by '/'
  std::string mode;
  bool operator==(const PartMode&) const = default;
};

}  // namespace maquette
