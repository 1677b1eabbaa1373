#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace maquette {

/// One named part of a bake file: columns of equal length.
struct BakeTable {
  std::string name;
  std::map<std::string, std::vector<std::uint32_t>> integers;
  std::map<std::string, std::vector<float>> floats;
};

/// Results of long computations as multi-part OpenEXR: each part is a table, each channel a column, laid out in rows of
/// 4096 pixels and padded with 0; any EXR viewer can open it. Attributes (provenance: the inputs of the computation)
/// and a checksum of all columns are text attributes of the first part.
struct BakeFile {
  std::map<std::string, std::string> attributes;
  std::vector<BakeTable> tables;
  /// Throws Error naming `path` when there is no such table or column.
  const BakeTable& table(const std::string& path, const std::string& name) const;
  const std::vector<std::uint32_t>& integers(const std::string& path, const std::string& table,
                                             const std::string& column) const;
  const std::vector<float>& floats(const std::string& path, const std::string& table, const std::string& column) const;
};

/// Writes to a temporary file beside `path` and renames it. Throws Error.
void save_bake_file(const std::string& path, const BakeFile& file);
/// Throws Error when the file is absent, truncated or no bake file, or when the checksum does not match.
BakeFile load_bake_file(const std::string& path);

}  // namespace maquette
