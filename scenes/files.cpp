#include "scenes/files.h"

#define XXH_INLINE_ALL
#include <signal.h>
#include <unistd.h>
#include <xxhash.h>

#include <atomic>
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <mutex>
#include <set>
#include <span>
#include <system_error>

#include "scenes/cache_entry.h"
#include "scenes/error.h"

namespace maquette {

namespace fs = std::filesystem;

namespace {

constexpr const char* kTemporary = ".partial-";

/// A number of this machine: others may share the folder.
unsigned host_number() {
  static const unsigned number = [] {
    char name[256] = {};
    gethostname(name, sizeof name - 1);
    return static_cast<unsigned>(content_hash(std::as_bytes(std::span(name, std::strlen(name)))) & 0xffffffffu);
  }();
  return number;
}

/// Whether a file of this name is the temporary one of a process of this machine that has ended.
bool is_left_behind(const std::string& name) {
  const std::size_t at = name.find(kTemporary);
  if (at == std::string::npos || name.front() != '.') return false;
  unsigned host = 0, number = 0;
  long process = 0;
  if (std::sscanf(name.c_str() + at, ".partial-%8x-%ld-%u", &host, &process, &number) != 3) return false;
  return host == host_number() && process > 0 && kill(static_cast<pid_t>(process), 0) != 0 && errno == ESRCH;
}

/// Once for each folder.
void remove_left_behind(const fs::path& folder) {
  static std::mutex mutex;
  static std::set<fs::path> seen;
  {
    const std::lock_guard lock(mutex);
    if (!seen.insert(folder).second) return;
  }
  std::error_code code;
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, code), end; !code && entry != end;
       entry.increment(code)) {
    std::error_code ignored;
    if (is_left_behind(entry->path().filename().string())) fs::remove(entry->path(), ignored);
  }
}

void remove_quietly(const std::string& path) {
  std::error_code ignored;
  fs::remove(path, ignored);
}

/// Layout of a cache entry's start; 40 bytes, native endianness (the cache never leaves the machine).
struct CacheHeader {
  char magic[8] = {'M', 'A', 'Q', 'C', 'A', 'C', 'H', 'E'};
  std::uint64_t version = 0;
  std::uint64_t key = 0;
  std::uint64_t size = 0;
  std::uint64_t checksum = 0;
};

}  // namespace

std::optional<fs::path> cache_folder() {
  if (const char* own = std::getenv("MAQUETTE_CACHE")) {
    return *own ? std::optional<fs::path>(own) : std::nullopt;
  }
  // Relative paths are to be ignored. Source: freedesktop.org, "XDG Base Directory Specification", version 0.8.
  const char* xdg = std::getenv("XDG_CACHE_HOME");
  if (xdg && *xdg == '/') return fs::path(xdg) / "maquette";
  const char* home = std::getenv("HOME");
  if (home && *home) return fs::path(home) / ".cache" / "maquette";
  return std::nullopt;
}

namespace {

fs::path cache_entry(const fs::path& folder, const std::string& kind, int version, std::uint64_t key) {
  char name[64];
  std::snprintf(name, sizeof name, "-v%d-%016llx.bin", version, static_cast<unsigned long long>(key));
  return folder / (kind + name);
}

}  // namespace

std::string temporary_path(const std::string& path) {
  static std::atomic<unsigned> counter{0};
  const fs::path target(path);
  remove_left_behind(target.parent_path());
  char marker[64];
  std::snprintf(marker, sizeof marker, "%s%08x-%ld-%u", kTemporary, host_number(), static_cast<long>(::getpid()),
                counter++);
  constexpr std::size_t kMost = 64;  // of the name, and of its extension
  std::string name = target.stem().string().substr(0, kMost);
  name.insert(0, 1, '.').append(marker).append(target.extension().string().substr(0, kMost));
  return (target.parent_path() / name).string();
}

std::string lower_extension(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

std::vector<std::byte> read_file(const std::string& path, std::size_t max_bytes) {
  std::error_code code;
  const fs::file_status status = fs::status(path, code);
  if (!fs::exists(status)) throw Error(path, "does not exist", "check the path");
  if (fs::is_directory(status)) throw Error(path, "is a folder, not a file", "name a file in it");
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw Error(path, std::string("cannot be read (") + std::strerror(errno) + ")", "check its permissions");
  std::vector<std::byte> bytes;
  if (fs::is_regular_file(status)) {
    const std::uintmax_t size = fs::file_size(path, code);
    if (code) throw Error(path, "cannot be read (" + code.message() + ")");
    if (size > max_bytes) {
      throw Error(path, "has " + std::to_string(size) + " bytes, at most " + std::to_string(max_bytes) + " expected",
                  "name another file");
    }
    bytes.resize(size);
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    bytes.resize(static_cast<std::size_t>(stream.gcount()));
    return bytes;
  }
  // A pipe or device has no known size, a device no end.
  constexpr std::size_t kMostOfAPipe = std::size_t{1} << 28;
  max_bytes = std::min(max_bytes, kMostOfAPipe);
  char chunk[65536];
  while (stream.read(chunk, sizeof chunk), stream.gcount() > 0) {
    const auto* begin = reinterpret_cast<const std::byte*>(chunk);
    bytes.insert(bytes.end(), begin, begin + stream.gcount());
    if (bytes.size() > max_bytes) {
      throw Error(path, "has more than the " + std::to_string(max_bytes) + " bytes expected", "name another file");
    }
  }
  return bytes;
}

void write_file_atomically(const std::string& path, std::span<const std::byte> bytes) {
  write_atomically(path, [&](const std::string& temporary) {
    std::ofstream stream(temporary, std::ios::binary);
    stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (!stream) {
      throw Error(path, std::string("cannot be written (") + std::strerror(errno) + ")",
                  "choose a writable folder with enough space");
    }
  });
}

bool is_written_through(const std::string& path) {
  std::error_code code;
  const fs::file_status status = fs::status(path, code);
  return fs::exists(status) && !fs::is_directory(status) &&
         (!fs::is_regular_file(status) || path.starts_with("/dev/") || path.starts_with("/proc/"));
}

std::string link_target(const std::string& path) {
  std::error_code code;
  fs::path target = path;
  for (int i = 0; i < 40 && fs::is_symlink(target, code); ++i) {  // the limit of Linux
    const fs::path next = fs::read_symlink(target, code);
    if (code) break;
    target = target.parent_path() / next;  // an absolute target replaces the path
  }
  if (fs::is_symlink(target, code))
    throw Error(path, "is a symbolic link that leads nowhere: a loop of links", "remove it");
  return target.string();
}

namespace {

/// Writes to a temporary file and copies its bytes into the target: a pipe or a device cannot be replaced by renaming.
void write_through(const std::string& path, const std::function<void(const std::string&)>& write) {
  const std::string temporary = temporary_path((fs::temp_directory_path() / fs::path(path).filename()).string());
  try {
    write(temporary);
    const std::vector<std::byte> bytes = read_file(temporary);
    std::ofstream stream(path, std::ios::binary | std::ios::app);
    stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (!stream) throw Error(path, std::string("cannot be written (") + std::strerror(errno) + ")", "name a file");
  } catch (...) {
    remove_quietly(temporary);
    throw;
  }
  remove_quietly(temporary);
}

}  // namespace

void write_atomically(const std::string& named, const std::function<void(const std::string&)>& write) {
  std::error_code code;
  if (named.empty()) throw Error("", "no output file named", "give a file name");
  if (is_written_through(named)) return write_through(named, write);
  const std::string path = link_target(named);
  if (fs::is_directory(path, code)) throw Error(path, "is a folder, not a file", "give a file name in it");
  const fs::path parent = fs::path(path).parent_path();
  if (!parent.empty() && !fs::is_directory(parent, code)) {
    throw Error(path, "cannot be written, its folder does not exist", "create the folder " + parent.string());
  }
  const std::string temporary = temporary_path(path);
  try {
    write(temporary);
    fs::rename(temporary, path, code);
    if (code) throw Error(path, "cannot be written (" + code.message() + ")", "choose a writable folder");
  } catch (...) {
    remove_quietly(temporary);
    throw;
  }
}

std::uint64_t file_stamp(const std::string& path) {
  std::error_code code;
  if (!fs::exists(path, code)) return 0;
  const bool folder = fs::is_directory(path, code);
  const std::uint64_t parts[] = {
      folder ? 0 : fs::file_size(path, code),
      static_cast<std::uint64_t>(fs::last_write_time(path, code).time_since_epoch().count())};
  return content_hash(std::as_bytes(std::span(parts)));
}

std::uint64_t content_hash(std::span<const std::byte> bytes, std::uint64_t seed) {
  return XXH3_64bits_withSeed(bytes.data(), bytes.size(), seed);
}

namespace {

/// The header of an entry of this content, which the stream is read behind; nothing where it is none.
std::optional<CacheHeader> read_cache_header(std::ifstream* stream, int version, std::uint64_t key) {
  if (!*stream) return std::nullopt;
  const std::streamoff length = stream->tellg();
  stream->seekg(0);
  const CacheHeader expected;
  CacheHeader header;
  if (length < static_cast<std::streamoff>(sizeof header)) return std::nullopt;
  stream->read(reinterpret_cast<char*>(&header), sizeof header);
  if (!*stream || std::memcmp(header.magic, expected.magic, sizeof header.magic) != 0 ||
      header.version != static_cast<std::uint64_t>(version) || header.key != key ||
      header.size != static_cast<std::uint64_t>(length) - sizeof header) {
    return std::nullopt;
  }
  return header;
}

}  // namespace

std::optional<std::vector<std::byte>> cache_load(const std::string& kind, int version, std::uint64_t key) {
  const std::optional<fs::path> folder = cache_folder();
  if (!folder) return std::nullopt;
  std::ifstream stream(cache_entry(*folder, kind, version, key), std::ios::binary | std::ios::ate);
  const std::optional<CacheHeader> header = read_cache_header(&stream, version, key);
  if (!header) return std::nullopt;
  std::vector<std::byte> payload(header->size);
  stream.read(reinterpret_cast<char*>(payload.data()), static_cast<std::streamsize>(payload.size()));
  if (!stream || content_hash(payload, key) != header->checksum) return std::nullopt;
  return payload;
}

bool cache_holds(const std::string& kind, int version, std::uint64_t key) {
  const std::optional<fs::path> folder = cache_folder();
  if (!folder) return false;
  std::ifstream stream(cache_entry(*folder, kind, version, key), std::ios::binary | std::ios::ate);
  return read_cache_header(&stream, version, key).has_value();
}

void cache_store(const std::string& kind, int version, std::uint64_t key, std::span<const std::byte> bytes) {
  const std::optional<fs::path> folder = cache_folder();
  if (!folder) return;
  std::error_code code;
  fs::create_directories(*folder, code);
  CacheHeader header;
  header.version = static_cast<std::uint64_t>(version);
  header.key = key;
  header.size = bytes.size();
  header.checksum = content_hash(bytes, key);
  try {
    write_atomically(cache_entry(*folder, kind, version, key).string(), [&](const std::string& temporary) {
      std::ofstream stream(temporary, std::ios::binary);
      stream.write(reinterpret_cast<const char*>(&header), sizeof header);
      stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
      stream.close();
      if (!stream) throw Error(temporary, "cannot be written");
    });
  } catch (const std::exception&) {
    // Best effort: the table is computed again next time.
  }
}

}  // namespace maquette
