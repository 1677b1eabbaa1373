#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace maquette {

/// With its dot and in lower case, of a name alone; empty without one.
std::string lower_extension(const std::string& path);

/// Whole file as bytes. Throws Error when it is missing, a folder, or larger than `max_bytes`.
std::vector<std::byte> read_file(const std::string& path, std::size_t max_bytes = std::size_t{4} << 30);

/// Writes `bytes` to a temporary file beside `path` and renames it: readers see the old or the new file, never half.
/// Throws Error (unwritable folder, full disk) and removes the temporary.
void write_file_atomically(const std::string& path, std::span<const std::byte> bytes);

/// True for what is there and no regular file to be replaced (a pipe, a device), and for names in /dev and /proc.
bool is_written_through(const std::string& path);

/// The file that a chain of symbolic links ends in, there or not; `path` itself where it is no link.
std::string link_target(const std::string& path);

/// Calls `write(temporary_path)` and renames the temporary to what `path` names, links followed; removes it when
/// `write` throws. What is_written_through gets the bytes instead.
void write_atomically(const std::string& path, const std::function<void(const std::string&)>& write);

/// 64-bit content hash (xxHash3), chained by `seed`.
std::uint64_t content_hash(std::span<const std::byte> bytes, std::uint64_t seed = 0);

/// Derived tables on disk, by content: `$XDG_CACHE_HOME/maquette` or `~/.cache/maquette`
/// (`MAQUETTE_CACHE` overrides; empty value switches caching off). A damaged or unreadable entry counts as absent.
/// `kind` and `version` name the format, so that changing an algorithm means raising its version.
std::optional<std::filesystem::path> cache_folder();
std::optional<std::vector<std::byte>> cache_load(const std::string& kind, int version, std::uint64_t key);
/// Best effort: a cache that cannot be written is not an error.
void cache_store(const std::string& kind, int version, std::uint64_t key, std::span<const std::byte> bytes);

}  // namespace maquette
