#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "render/bake/bake_attributes.h"
#include "render/bake/bake_keys.h"
#include "render/bake/bake_kind.h"
#include "scenes/cache_entry.h"
#include "scenes/error.h"
#include "scenes/files.h"

namespace maquette {

/// For keys: the hash of values in turn, chained by `seed`.
template <typename T>
std::uint64_t chain_hash(const std::vector<T>& values, std::uint64_t seed) {
  return content_hash(std::as_bytes(std::span(values)), seed);
}

template <typename T>
void append_bytes(const std::vector<T>& values, std::vector<std::byte>* bytes) {
  const auto raw = std::as_bytes(std::span(values));
  bytes->insert(bytes->end(), raw.begin(), raw.end());
}

/// A kind whose whole results are kept in the cache, by content.
template <typename Input, typename Value>
class CachedBakeKind : public BakeKind<Input, Value> {
 public:
  Baked<Value> load(const Input& input) override {
    const std::optional<std::uint64_t> key = cache_key(input);
    const auto bytes = key ? cache_load(name_, version_, *key) : std::nullopt;
    std::optional<Value> value = bytes ? unpack(input, *bytes) : std::nullopt;
    if (!value) return {};
    return {std::make_shared<const Value>(std::move(*value)), true, true};
  }
  void save(const Input& input, const Value& value, bool complete) override {
    if (!complete) return;
    if (const auto key = cache_key(input)) cache_store(name_, version_, *key, pack(value));
  }
  std::string key(const Input& input) const override {
    const std::optional<std::uint64_t> key = cache_key(input);
    return key ? hex(*key) : std::string();
  }
  /// Whether the cache has the result of this key.
  bool keeps(const std::string& key) const {
    return is_bake_key(key) && cache_holds(name_, version_, std::strtoull(key.c_str(), nullptr, 16));
  }

 protected:
  /// `version` is raised whenever the result for the same input changes.
  CachedBakeKind(const char* name, int version) : name_(name), version_(version) {}
  /// Of all that the result depends on; nothing: it is not kept.
  virtual std::optional<std::uint64_t> cache_key(const Input&) const = 0;
  virtual std::vector<std::byte> pack(const Value&) const = 0;
  /// Nothing when the bytes do not fit the input.
  virtual std::optional<Value> unpack(const Input&, const std::vector<std::byte>&) const = 0;

 private:
  const char* name_;
  int version_;
};

/// Where a bake is kept that can be resumed.
struct BakePlace {
  std::string path;        ///< empty: nowhere
  bool must_save = false;  ///< named by the user: what cannot be written is an error
  bool writable = true;    ///< else it is only read: what a review or a setting names is not for drawing to write
};

/// A kind that is kept in one file, whole or in part, and resumed from it; one that is damaged is as good as absent.
template <typename Input, typename Value>
class FileBakeKind : public BakeKind<Input, Value> {
 public:
  Baked<Value> load(const Input& input) override {
    const BakePlace at = place(input);
    std::error_code ignored;
    if (at.path.empty() || !std::filesystem::exists(at.path, ignored)) return {};
    try {
      return {std::make_shared<const Value>(read(at.path)), false, true};
    } catch (const Error&) {
      return {};  // damaged: it is made anew
    }
  }
  void save(const Input& input, const Value& value, bool complete) override {
    const BakePlace at = place(input);
    if (at.path.empty() || !at.writable) return;
    try {
      std::error_code ignored;
      std::filesystem::create_directories(std::filesystem::path(at.path).parent_path(), ignored);
      write(at.path, input, value, complete);
    } catch (const Error&) {
      if (at.must_save) throw;
    }
  }

 protected:
  virtual BakePlace place(const Input&) const = 0;
  /// Throws Error.
  virtual Value read(const std::string& path) const = 0;
  virtual void write(const std::string& path, const Input&, const Value&, bool complete) const = 0;
};

}  // namespace maquette
