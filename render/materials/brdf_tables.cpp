#include "render/materials/brdf_tables.h"

#include <cstring>
#include <span>

#include "render/materials/bandwidth.h"
#include "render/materials/symmetric_brdf.h"
#include "scenes/files.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

/// Incremented whenever importance, albedo or bandwidth change.
constexpr int kTablesVersion = 1;
constexpr const char* kTablesKind = "brdf-tables";

template <typename Visit>
void visit_arrays(BrdfTables& tables, const Visit& visit) {
  visit(tables.theta_cells, std::size_t{kElevationCount} * kThetaCellCount);
  visit(tables.phi_cells, std::size_t{kElevationCount} * kThetaCellCount * kPhiCellCount);
  visit(tables.albedo, std::size_t{kAlbedoCount});
  visit(tables.bandwidth, std::size_t{kThetaHCount} * kThetaDCount);
}

std::vector<std::byte> to_bytes(BrdfTables& tables) {
  std::vector<std::byte> bytes;
  visit_arrays(tables, [&](auto& values, std::size_t) {
    const auto view = std::as_bytes(std::span(values));
    bytes.insert(bytes.end(), view.begin(), view.end());
  });
  return bytes;
}

std::optional<BrdfTables> from_bytes(std::span<const std::byte> bytes) {
  BrdfTables tables;
  std::size_t size = 0;
  visit_arrays(tables, [&](auto& values, std::size_t count) {
    values.resize(count);
    size += std::as_bytes(std::span(values)).size();
  });
  if (bytes.size() != size) return std::nullopt;
  std::size_t offset = 0;
  visit_arrays(tables, [&](auto& values, std::size_t) {
    const auto view = std::as_writable_bytes(std::span(values));
    std::memcpy(view.data(), bytes.data() + offset, view.size());
    offset += view.size();
  });
  return tables;
}

}  // namespace

BrdfTables compute_brdf_tables(const BrdfTable& brdf) {
  BrdfTables tables;
  const SymmetricBrdf symmetric(brdf);
  parallel_invoke([&] { compute_importance(symmetric, tables); }, [&] { compute_albedo(symmetric, tables); },
                  [&] { tables.bandwidth = compute_bandwidth(brdf); });
  return tables;
}

BrdfTables load_brdf_tables(const BrdfTable& brdf) {
  if (const auto bytes = cache_load(kTablesKind, kTablesVersion, brdf.hash)) {
    if (std::optional<BrdfTables> tables = from_bytes(*bytes)) return std::move(*tables);
  }
  BrdfTables tables = compute_brdf_tables(brdf);
  cache_store(kTablesKind, kTablesVersion, brdf.hash, to_bytes(tables));
  return tables;
}

}  // namespace maquette
