#pragma once

#include <cstddef>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace maquette::gltf {

using Json = nlohmann::json;
using Bytes = std::span<const std::byte>;

/// What to do about a file whose data, or whose description of it, is wrong.
inline constexpr const char* kDamaged = "the file is damaged; export it again";
inline constexpr const char* kInvalid = "the file does not follow glTF 2.0; export it again";

/// Collects warnings about unsupported features: one line per kind, naming the first element and the number of others.
class Warnings {
 public:
  /// `what` is the kind and the text; `where` the element, e.g. `meshes[3].primitives[0]` (may be empty).
  void add(const std::string& what, const std::string& where = {});
  void merge(const Warnings& other);
  /// In the order of first appearance; an element by itself has one line.
  std::vector<std::string> lines() const;

 private:
  struct Entry {
    std::string what, where;
    std::size_t count = 0;
  };
  std::vector<Entry> entries_;
  std::map<std::string, std::size_t> index_;
};

/// The two parts of a .glb, or all of a .gltf as `json` (with an empty `binary`). Views into the given bytes.
struct Container {
  std::string_view json;
  Bytes binary;
  bool is_binary = false;
};
/// Throws Error: wrong magic or version, truncated, chunks out of order.
Container split_container(const std::string& path, Bytes file, Warnings* warnings);

/// Parses the JSON and checks it against the schema of glTF 2.0: types, required members, indices, nesting depth. After
/// this the readers need no further checks of structure. Throws Error naming the member.
Json parse_checked(const std::string& path, std::string_view text);

/// Throws Error for an unsupported required extension; warns once for each other unsupported extension.
void check_extensions(const std::string& path, const Json& root, Warnings* warnings);

/// True for the scheme `data` in any case.
bool is_data_uri(std::string_view uri);
/// What a `data:` URI says that its bytes are, in lower case and without parameters; may be empty.
std::string media_type(std::string_view uri);
/// Bytes of a `data:` URI (base64 or percent-encoded text). Throws Error.
std::vector<std::byte> decode_data_uri(const std::string& where, std::string_view uri);
/// Path of a relative URI, resolved against `path`: decoded, or as it is written where only that exists.
std::string resolve_uri(const std::string& path, std::string_view uri);
/// True for `http:...`, `file:...`.
bool has_scheme(std::string_view uri);
/// Bytes of the file that a relative URI names. Throws Error, also for another scheme (`http:`, `file:`), and for what is
/// no regular file: a device has no end.
std::vector<std::byte> read_uri(const std::string& path, std::string_view uri);

/// `text` for a message: in quotation marks, or its length alone when it may be a payload.
std::string name_text(std::string_view text);
/// A node for a message: by its name, or by its index where it has none.
std::string name_node(const std::string& name, std::size_t index);
/// A message as one line without payloads, whatever names and texts of libraries are in it: long words are cut, except
/// for the `folder` that they begin with.
std::string plain_line(std::string_view text, std::string_view folder);

/// Text of an Error: `path: element`.
std::string at(const std::string& path, const std::string& element);
std::string element(const char* array, std::size_t index);

}  // namespace maquette::gltf
