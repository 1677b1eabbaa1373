#include "render/visibility/visibility_kind.h"

#include <cmath>
#include <cstring>
#include <utility>

namespace maquette {

namespace {

template <typename T>
const std::byte* take(const std::byte* bytes, std::size_t count, std::vector<T>* values) {
  values->resize(count);
  if (count > 0) std::memcpy(static_cast<void*>(values->data()), bytes, count * sizeof(T));
  return bytes + count * sizeof(T);
}

DrawnVisibility prepare(VisibilityBake bake, const VisibilityJob& job) {
  std::vector<VisibilitySides> sides = visibility_sides(bake.vertices, job.geometry.normals);
  return {std::make_shared<const VisibilityBake>(std::move(bake)), std::move(sides)};
}

}  // namespace

VisibilityKind::VisibilityKind() : CachedBakeKind("visibility", 3) {}

Baked<DrawnVisibility> VisibilityKind::run(const VisibilityJob& job, const Baked<DrawnVisibility>&,
                                           const BakeTask<DrawnVisibility>& task) {
  auto bake = bake_visibility(job.geometry, job.transmits, job.passages, task.cancel, task.progress);
  if (!bake) return {};
  return {std::make_shared<const DrawnVisibility>(prepare(std::move(*bake), job)), true};
}

std::optional<std::uint64_t> VisibilityKind::cache_key(const VisibilityJob& job) const {
  const FlatGeometry& geometry = job.geometry;
  std::vector<std::uint32_t> items;
  for (std::size_t i = 0; i < geometry.items.size(); ++i) {
    const DrawItem& item = geometry.items[i];
    items.insert(items.end(),
                 {item.first_index, item.index_count, i < job.transmits.size() && job.transmits[i] ? 1u : 0u});
  }
  std::uint64_t key = chain_hash(job.passages, chain_hash(items, geometry.positions.size()));
  key = chain_hash(geometry.positions, key);
  key = chain_hash(geometry.normals, key);
  return chain_hash(geometry.indices, key);
}

/// All arrays one after the other.
std::vector<std::byte> VisibilityKind::pack(const DrawnVisibility& drawn) const {
  std::vector<std::byte> bytes;
  append_bytes(drawn.bake->vertices, &bytes);
  append_bytes(drawn.bake->bandwidth, &bytes);
  append_bytes(drawn.bake->transmittance, &bytes);
  return bytes;
}

std::optional<DrawnVisibility> VisibilityKind::unpack(const VisibilityJob& job,
                                                      const std::vector<std::byte>& bytes) const {
  VisibilityBake bake;
  const std::size_t count = job.geometry.positions.size();
  if (bytes.size() != count * (sizeof bake.vertices[0] + sizeof bake.bandwidth[0] + sizeof bake.transmittance[0]))
    return std::nullopt;
  take(take(take(bytes.data(), count, &bake.vertices), count, &bake.bandwidth), count, &bake.transmittance);
  for (float value : bake.bandwidth)
    if (!(value >= 0.0f) || !std::isfinite(value)) return std::nullopt;
  for (const glm::vec2& value : bake.transmittance)
    if (!(value.x >= 0.0f && value.x <= 1.0f && value.y >= 0.0f && value.y <= 1.0f)) return std::nullopt;
  return prepare(std::move(bake), job);
}

}  // namespace maquette
