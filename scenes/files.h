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

/// Extension with its dot, in lower case, of the last path component; empty without one.
std::string lower_extension(const std::string& path);

/// Whole file as bytes. Throws Error when it is missing, a folder, or larger than `max_bytes`.
std::vector<std::byte> read_file(const std::string& path, std::size_t max_bytes = std::size_t{4} << 30);

/// Writes `bytes` to a temporary file beside `path` and renames it: readers see the old or the new file, never a part.
/// Throws Error (unwritable folder, full disk) and removes the temporary file.
void write_file_atomically(const std::string& path, std::span<const std::byte> bytes);

/// True for existing paths that are not regular files (a pipe, a device), and for names in /dev and /proc.
bool is_written_through(const std::string& path);

/// The end of a chain of symbolic links, whether it exists or not; `path` itself when it is no link.
std::string link_target(const std::string& path);

/// Beside `path`, hidden, with the same extension, unlike any other. What runs that were killed have left of such files
/// in the folder is removed.
std::string temporary_path(const std::string& path);

/// Calls `write(temporary_path)` and renames the result to the target of `path`, following links; removes it when
/// `write` throws. Paths with is_written_through get the bytes instead.
void write_atomically(const std::string& path, const std::function<void(const std::string&)>& write);

/// Changes with a file that is written anew, without reading it: by its size and time. Of a folder when a file was last
/// added, removed or renamed in it: BTFs have tens of thousands. 0: there is nothing.
std::uint64_t file_stamp(const std::string& path);

/// 64-bit content hash (xxHash3), chained by `seed`.
std::uint64_t content_hash(std::span<const std::byte> bytes, std::uint64_t seed = 0);

/// Cache of derived tables on disk, by content: `$XDG_CACHE_HOME/maquette` or `~/.cache/maquette` (`MAQUETTE_CACHE`
/// overrides it; an empty value disables the cache). A damaged or unreadable entry counts as absent.
/// `kind` and `version` name the format: a changed algorithm must increase its version.
std::optional<std::filesystem::path> cache_folder();
std::optional<std::vector<std::byte>> cache_load(const std::string& kind, int version, std::uint64_t key);
/// Best effort: failing to write the cache is not an error.
void cache_store(const std::string& kind, int version, std::uint64_t key, std::span<const std::byte> bytes);

}  // namespace maquette
