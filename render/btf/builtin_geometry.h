#pragma once

#include <string>
#include <vector>

#include "render/btf/small_geometry.h"

namespace maquette {

/// One of the built-in materials with small-scale geometry.
struct BuiltinGeometry {
  std::string name;   ///< `btf-leather`
  std::string label;  ///< "Grained leather"
  std::string model;  ///< what it is made of
  SmallGeometry (*make)(int side);
  double tile_m = 0.0;  ///< side of the tile
};
/// Leather, woven fabric, knit, perforated leather.
const std::vector<BuiltinGeometry>& builtin_geometries();
/// Null when there is no such name (without `builtin:`).
const BuiltinGeometry* find_builtin_geometry(const std::string& name);

}  // namespace maquette
