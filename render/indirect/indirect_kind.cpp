#include "render/indirect/indirect_kind.h"

#include <cstring>
#include <utility>

#include "render/lights/light_numbers.h"

namespace maquette {

namespace {

/// Rays of all points together: 8 bytes each in main memory, 3 to 5 s on two cores.
constexpr std::size_t kRayBudget = std::size_t{1} << 24;

/// Numbers of every material that colour or emit light.
std::vector<float> material_numbers(const Scene& scene) {
  std::vector<float> numbers;
  for (const Material& m : scene.materials) {
    const std::vector<float> own = numbers_of(m);
    numbers.insert(numbers.end(), own.begin(), own.end());
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
  std::uint64_t key = chain_hash(items, job.sky.environment->hash);
  key = chain_hash(g.positions, key);
  key = chain_hash(g.normals, key);
  key = chain_hash(g.indices, key);
  key = chain_hash(g.uv0, key);
  key = chain_hash(g.colors, key);
  key = chain_hash(material_numbers(input.scene), key);
  key = chain_hash(light_numbers(input.scene), key);
  key = chain_hash(input.measured_hash, key);
  for (const TextureImage& image : input.scene.images) {
    key = chain_hash(image.rgba, key);
    if (!image.rgba16.empty()) key = chain_hash(image.rgba16, key);
  }
  return chain_hash(std::vector<float>{job.sky.rotation_rad, job.sky.scale}, key);
}

struct Header {
  std::int32_t sides, bias;
};

}  // namespace

IndirectKind::IndirectKind() : CachedBakeKind("indirect", 5) {}

Baked<IndirectResult> IndirectKind::load(const IndirectJob& job) {
  if (memory_.input != job.input) memory_ = {job.input, nullptr, {}};
  // With the links at hand a sky takes less time than the disk.
  if (memory_.links || job.bounces == IndirectBounces::none) return {};
  return CachedBakeKind::load(job);
}

Baked<IndirectResult> IndirectKind::run(const IndirectJob& job, const Baked<IndirectResult>&,
                                        const BakeTask<IndirectResult>& task) {
  const bool traced = !memory_.links;
  if (traced) {
    const auto show_first = [&](const IndirectLinks& links) {
      const auto solution =
          solve_indirect(links, *job.visibility, job.sky, IndirectBounces::step, nullptr, task.cancel);
      if (solution) task.publish({pack_indirect(links, solution->radiance), job.sky, job.bounces, job.input});
    };
    const bool shown = task.publish && job.bounces == IndirectBounces::all;
    memory_.links = trace_indirect_links(*job.input, kRayBudget, task.cancel, task.progress,
                                         shown ? show_first : std::function<void(const IndirectLinks&)>());
  }
  if (!memory_.links || task.cancel || job.bounces == IndirectBounces::none) return {};
  auto solution = solve_indirect(*memory_.links, *job.visibility, job.sky, job.bounces, &memory_.solution, task.cancel);
  if (!solution) return {};
  memory_.solution = std::move(*solution);
  IndirectResult result{pack_indirect(*memory_.links, memory_.solution.radiance), job.sky, job.bounces, job.input};
  // A sky that is turned would fill the disk.
  const bool keep = traced && job.bounces == IndirectBounces::all;
  return {std::make_shared<const IndirectResult>(std::move(result)), true, !keep};
}

std::optional<std::uint64_t> IndirectKind::cache_key(const IndirectJob& job) const {
  if (job.sky.environment->hash == 0) return std::nullopt;  // made in memory, not loaded
  return key_of(job);
}

std::vector<std::byte> IndirectKind::pack(const IndirectResult& result) const {
  std::vector<std::byte> bytes;
  append_bytes(std::vector<std::int32_t>{result.bake.sides, result.bake.bias}, &bytes);
  append_bytes(result.bake.vertices, &bytes);
  return bytes;
}

std::optional<IndirectResult> IndirectKind::unpack(const IndirectJob& job, const std::vector<std::byte>& bytes) const {
  struct {
    std::int32_t sides, bias;
  } header{};
  if (bytes.size() < sizeof header) return std::nullopt;
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.sides < 1 || header.sides > 2 || header.bias < -80 || header.bias > 120) return std::nullopt;
  const std::size_t count = job.input->geometry->positions.size() * static_cast<std::size_t>(header.sides);
  if (bytes.size() != sizeof header + count * sizeof(glm::uvec4)) return std::nullopt;
  IndirectResult result{{}, job.sky, job.bounces, job.input};
  result.bake.sides = header.sides;
  result.bake.bias = header.bias;
  result.bake.vertices.resize(count);
  if (count > 0)
    std::memcpy(static_cast<void*>(result.bake.vertices.data()), bytes.data() + sizeof header,
                count * sizeof(glm::uvec4));
  return result;
}

}  // namespace maquette
