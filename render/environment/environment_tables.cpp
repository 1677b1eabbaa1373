#include "render/environment/environment_tables.h"

#include <cstring>
#include <span>
#include <utility>

#include "render/environment/bandwidth.h"
#include "render/environment/importance.h"
#include "scenes/files.h"

namespace maquette {
namespace {

constexpr const char* kCacheKind = "environment-bandwidth";
constexpr int kCacheVersion = 5;

/// Cached bytes: two int32 (width, height), then both bandwidths.
bool read_cached_bandwidth(std::uint64_t key, EnvironmentTables& tables) {
  const auto bytes = cache_load(kCacheKind, kCacheVersion, key);
  std::int32_t size[2] = {0, 0};
  if (!bytes || bytes->size() < sizeof size) return false;
  std::memcpy(size, bytes->data(), sizeof size);
  if (size[0] < 1 || size[1] < 1 || size[0] > 4096 || size[1] > 4096) return false;
  const std::size_t count = static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]);
  if (bytes->size() != sizeof size + count * (1 + kSeenBandwidthCount) * sizeof(float)) return false;
  tables.bandwidth_width = size[0];
  tables.bandwidth_height = size[1];
  const std::byte* from = bytes->data() + sizeof size;
  for (auto [values, each] :
       {std::pair{&tables.bandwidth, std::size_t{1}}, {&tables.seen_bandwidth, kSeenBandwidthCount}}) {
    values->resize(count * each);
    std::memcpy(values->data(), from, values->size() * sizeof(float));
    from += values->size() * sizeof(float);
  }
  return true;
}

void store_bandwidth(std::uint64_t key, const EnvironmentTables& tables) {
  const std::int32_t size[2] = {tables.bandwidth_width, tables.bandwidth_height};
  const auto header = std::as_bytes(std::span(size));
  std::vector<std::byte> bytes(header.begin(), header.end());
  for (const auto* values : {&tables.bandwidth, &tables.seen_bandwidth}) {
    const auto added = std::as_bytes(std::span(*values));
    bytes.insert(bytes.end(), added.begin(), added.end());
  }
  cache_store(kCacheKind, kCacheVersion, key, bytes);
}

}  // namespace

EnvironmentTables compute_environment_tables(const Environment& environment) {
  EnvironmentTables tables;
  compute_importance(environment, tables);
  compute_bandwidth(environment, tables);
  return tables;
}

EnvironmentTables load_environment_tables(const Environment& environment) {
  EnvironmentTables tables;
  // Computing the importance of a large map is as fast as reading it.
  compute_importance(environment, tables);
  const std::uint64_t key = content_key(environment);
  if (read_cached_bandwidth(key, tables)) return tables;
  compute_bandwidth(environment, tables);
  store_bandwidth(key, tables);
  return tables;
}

}  // namespace maquette
