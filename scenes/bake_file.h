#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace maquette {

/// Columns of equal length: one named part of a bake file.
struct BakeTable {
  std::string name;
  std::map<std::string, std::vector<std::uint32_t>> integers;
  std::map<std::string, std::vector<float>> floats;
};

/// What took time to compute, as multi-part OpenEXR: a part is a table, a channel a column, laid out in rows of 4096
/// pixels and filled up with 0; any EXR viewer opens it. Attributes (provenance: what it was made from) and a checksum
/// of all columns are text attributes of the first part.
struct BakeFile {
  std::map<std::string, std::string> attributes;
  std::vector<BakeTable> tables;
  /// Throws Error naming `path` when there is no such table or column.
  const BakeTable& table(const std::string& path, const std::string& name) const;
  const std::vector<std::uint32_t>& integers(const std::string& path, const std::string& table,
                                             const std::string& column) const;
  const std::vector<float>& floats(const std::string& path, const std::string& table, const std::string& column) const;
};

/// Written beside `path` and renamed. Throws Error.
void save_bake_file(const std::string& path, const BakeFile& file);
/// Throws Error: no such file, no bake file, truncated, or a checksum that does not fit.
BakeFile load_bake_file(const std::string& path);

}  // namespace maquette
