#pragma once

#include <cstddef>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace maquette::gltf {

using Json = nlohmann::json;
using Bytes = std::span<const std::byte>;

/// Collects what a file asks for and is not supported: one line per kind, naming the first element and how many more.
class Warnings {
 public:
  /// `what` is the kind and the text; `where` the element, e.g. `meshes[3].primitives[0]` (may be empty).
  void add(const std::string& what, const std::string& where = {});
  void merge(const Warnings& other);
  /// In the order of first appearance.
  std::vector<std::string> lines() const;

 private:
  struct Entry {
    std::string what, where;
    std::size_t count = 0;
  };
  std::vector<Entry> entries_;
  std::map<std::string, std::size_t> index_;
};

/// The two parts of a .glb, or the whole of a .gltf as `json` (`binary` is then empty). Views into the bytes given.
struct Container {
  std::string_view json;
  Bytes binary;
  bool is_binary = false;
};
/// Throws Error: wrong magic or version, truncated, chunks out of order.
Container split_container(const std::string& path, Bytes file, Warnings* warnings);

/// Parses and checks the JSON against the shape of glTF 2.0: types, required members, every index within its array,
/// nesting depth. After this the readers need no further checks of structure. Throws Error naming the member.
Json parse_checked(const std::string& path, std::string_view text);

/// Throws Error for a required extension that is not read; warns once for each other extension that is not read.
void check_extensions(const std::string& path, const Json& root, Warnings* warnings);

/// Bytes of a `data:` URI (base64 or percent-encoded text). Throws Error.
std::vector<std::byte> decode_data_uri(const std::string& where, std::string_view uri);
/// A relative URI as a path beside `path`.
std::string resolve_uri(const std::string& path, std::string_view uri);

/// Text of an Error: `path: element`.
std::string at(const std::string& path, const std::string& element);
std::string element(const char* array, std::size_t index);

}  // namespace maquette::gltf
