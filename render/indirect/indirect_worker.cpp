#include "render/indirect/indirect_worker.h"

#include <cstring>
#include <span>
#include <utility>

#include "scenes/files.h"

namespace maquette {

namespace {

constexpr const char* kCacheKind = "indirect";
/// Raised whenever the result for the same input changes.
constexpr int kCacheVersion = 3;
/// Rays of all points together: 8 bytes each in main memory, 3 to 5 s on two cores.
constexpr std::size_t kRayBudget = std::size_t{1} << 24;

template <typename T>
std::uint64_t chain(const std::vector<T>& values, std::uint64_t seed) {
  return content_hash(std::as_bytes(std::span(values)), seed);
}

/// Numbers of every material that colour or emit light.
std::vector<float> material_numbers(const Scene& scene) {
  std::vector<float> numbers;
  for (const Material& m : scene.materials) {
    for (const glm::vec3& v : {glm::vec3(m.base_color), m.emissive, m.specular_color})
      numbers.insert(numbers.end(), {v.x, v.y, v.z});
    numbers.insert(numbers.end(), {m.base_color.a, m.metallic, m.roughness, m.clearcoat, m.clearcoat_roughness,
                                   m.transmission, m.ior, m.specular, m.normal_scale, m.alpha_cutoff});
    for (const bool flag : {m.double_sided, m.glass, m.tint_measured, m.unlit}) numbers.push_back(flag ? 1.0f : 0.0f);
    numbers.push_back(static_cast<float>(m.alpha_mode));
    for (const TextureRef* t : {&m.base_color_texture, &m.metallic_roughness_texture, &m.emissive_texture}) {
      numbers.insert(numbers.end(),
                     {static_cast<float>(t->image), static_cast<float>(t->uv_set), t->offset.x, t->offset.y, t->scale.x,
                      t->scale.y, t->rotation_rad, static_cast<float>(t->wrap_s), static_cast<float>(t->wrap_t)});
    }
  }
  return numbers;
}

std::vector<float> light_numbers(const Scene& scene) {
  std::vector<float> numbers;
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
    const Node& node = scene.nodes[n];
    if (!node.visible || node.light < 0 || node.light >= static_cast<int>(scene.lights.size())) continue;
    const PunctualLight& l = scene.lights[static_cast<std::size_t>(node.light)];
    numbers.insert(numbers.end(), {static_cast<float>(l.kind), l.color.x, l.color.y, l.color.z, l.intensity, l.range_m,
                                   l.inner_cone_rad, l.outer_cone_rad});
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 3; ++r) numbers.push_back(world[n][c][r]);
  }
  return numbers;
}

std::uint64_t key_of(const IndirectJob& job) {
  const IndirectInput& input = *job.input;
  const FlatGeometry& g = *input.geometry;
  std::vector<std::uint32_t> items;
  for (std::size_t i = 0; i < g.items.size(); ++i) {
    const DrawItem& item = g.items[i];
    int material = -1;
    if (item.patch >= 0) {
      material = input.scene.patches[static_cast<std::size_t>(item.patch)].material;
    } else {
      material = material_of(
          input.scene.meshes[static_cast<std::size_t>(item.mesh)].primitives[static_cast<std::size_t>(item.primitive)],
          input.variant);
    }
    items.insert(items.end(), {item.first_index, item.index_count, static_cast<std::uint32_t>(material),
                               i < input.transmits.size() && input.transmits[i] ? 1u : 0u});
  }
  std::uint64_t key = chain(items, job.sky.environment->hash);
  key = chain(g.positions, key);
  key = chain(g.normals, key);
  key = chain(g.indices, key);
  key = chain(g.uv0, key);
  key = chain(g.colors, key);
  key = chain(material_numbers(input.scene), key);
  key = chain(light_numbers(input.scene), key);
  key = chain(input.measured_hash, key);
  for (const TextureImage& image : input.scene.images) key = chain(image.rgba, key);
  return chain(std::vector<float>{job.sky.rotation_rad, job.sky.scale}, key);
}

struct Header {
  std::int32_t sides, bias;
};

std::optional<IndirectBake> unpack(const std::vector<std::byte>& bytes, std::size_t vertex_count) {
  Header header{};
  if (bytes.size() < sizeof header) return std::nullopt;
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.sides < 1 || header.sides > 2) return std::nullopt;
  const std::size_t count = vertex_count * static_cast<std::size_t>(header.sides);
  if (bytes.size() != sizeof header + count * sizeof(glm::uvec4) || header.bias < -80 || header.bias > 120)
    return std::nullopt;
  IndirectBake bake;
  bake.sides = header.sides;
  bake.bias = header.bias;
  bake.vertices.resize(count);
  if (count > 0)
    std::memcpy(static_cast<void*>(bake.vertices.data()), bytes.data() + sizeof header, count * sizeof(glm::uvec4));
  return bake;
}

void store(std::uint64_t key, const IndirectBake& bake) {
  const Header header{bake.sides, bake.bias};
  const auto head = std::as_bytes(std::span(&header, 1));
  const auto body = std::as_bytes(std::span(bake.vertices));
  std::vector<std::byte> bytes(head.begin(), head.end());
  bytes.insert(bytes.end(), body.begin(), body.end());
  cache_store(kCacheKind, kCacheVersion, key, bytes);
}

}  // namespace

std::optional<IndirectBake> load_indirect(const IndirectJob& job, IndirectMemory* memory,
                                          const std::atomic<bool>& cancel,
                                          const std::function<void(double)>& progress) {
  if (memory->input != job.input) *memory = {job.input, nullptr, {}};
  const bool cacheable = job.sky.environment->hash != 0;  // 0: made in memory, not loaded
  const std::uint64_t key = cacheable ? key_of(job) : 0;
  if (cacheable && !memory->links && job.bounces != IndirectBounces::none) {
    if (const auto bytes = cache_load(kCacheKind, kCacheVersion, key))
      if (auto bake = unpack(*bytes, job.input->geometry->positions.size())) return bake;
  }
  // With the links at hand a sky takes less time than the disk, and one that is turned would fill it.
  const bool traced = !memory->links;
  if (traced) memory->links = trace_indirect_links(*job.input, kRayBudget, cancel, progress);
  if (!memory->links || cancel || job.bounces == IndirectBounces::none) return std::nullopt;
  auto solution = solve_indirect(*memory->links, *job.visibility, job.sky, job.bounces, &memory->solution, cancel);
  if (!solution) return std::nullopt;
  memory->solution = std::move(*solution);
  IndirectBake bake = pack_indirect(*memory->links, memory->solution.radiance);
  if (cacheable && traced && job.bounces == IndirectBounces::all) store(key, bake);
  return bake;
}

IndirectWorker::IndirectWorker()
    : BackgroundWorker(
          [memory = IndirectMemory()](
              const IndirectJob& job, const std::atomic<bool>& cancel,
              const std::function<void(double)>& progress) mutable -> std::optional<IndirectResult> {
            std::optional<IndirectBake> bake = load_indirect(job, &memory, cancel, progress);
            if (!bake) return std::nullopt;
            return IndirectResult{std::move(*bake), job.sky, job.bounces, job.input};
          },
          [](const IndirectJob& before, const IndirectJob& next) { return before.input == next.input; }) {}

}  // namespace maquette
