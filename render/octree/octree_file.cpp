#include "render/octree/octree_file.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <span>

#include "scenes/bake_file.h"
#include "scenes/error.h"
#include "scenes/files.h"

namespace maquette {

namespace {

constexpr const char* kOctreeKind = "octree";
constexpr int kOctreeVersion = 6;
constexpr std::size_t kSumFloats = 10 + 4 * OctreeSums::kMaterials;
constexpr std::size_t kLevels = kOctreeMaxLevels + 1;

void append_bounds(std::vector<float>* out, const Bounds& b) {
  out->insert(out->end(), {b.min.x, b.min.y, b.min.z, b.max.x, b.max.y, b.max.z});
}
Bounds read_bounds(const float* v) { return {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}}; }

void append_sums(const OctreeSums& s, std::vector<float>* floats, std::vector<std::uint32_t>* materials) {
  for (double v : {s.area, s.normal.x, s.normal.y, s.normal.z, s.centroid.x, s.centroid.y, s.centroid.z, s.deviation,
                   s.low, s.high})
    floats->push_back(static_cast<float>(v));
  for (double v : s.material_area) floats->push_back(static_cast<float>(v));
  for (const glm::dvec3& c : s.material_color)
    for (int i = 0; i < 3; ++i) floats->push_back(static_cast<float>(c[i]));
  materials->insert(materials->end(), s.material.begin(), s.material.end());
  materials->insert(materials->end(), s.triangle.begin(), s.triangle.end());
}

OctreeSums read_sums(const float* v, const std::uint32_t* materials) {
  OctreeSums s;
  s.area = static_cast<double>(v[0]);
  s.normal = glm::dvec3(v[1], v[2], v[3]);
  s.centroid = glm::dvec3(v[4], v[5], v[6]);
  s.deviation = static_cast<double>(v[7]);
  s.low = static_cast<double>(v[8]);
  s.high = static_cast<double>(v[9]);
  for (std::size_t k = 0; k < OctreeSums::kMaterials; ++k) {
    s.material_area[k] = static_cast<double>(v[10 + k]);
    const float* color = v + 10 + OctreeSums::kMaterials + 3 * k;
    s.material_color[k] = glm::dvec3(color[0], color[1], color[2]);
    s.material[k] = materials[k];
    s.triangle[k] = materials[OctreeSums::kMaterials + k];
  }
  return s;
}

int whole_number(const std::string& path, const BakeFile& file, const std::string& name, int low, int high) {
  const auto found = file.attributes.find(name);
  const int value = found == file.attributes.end() ? low - 1 : std::atoi(found->second.c_str());
  if (value < low || value > high) throw Error(path, "the octree's " + name + " is out of range", "bake it again");
  return value;
}

}  // namespace

void save_octree_file(const std::string& path, const OctreeBricks& bricks, const std::string& scene, bool complete) {
  const OctreeGrid& grid = bricks.grid;
  BakeFile file;
  file.attributes = {{"kind", kOctreeKind},
                     {"version", std::to_string(kOctreeVersion)},
                     {"scene", scene},
                     {"complete", complete ? "1" : "0"},
                     {"depth", std::to_string(grid.depth)},
                     {"detail", std::to_string(grid.detail)},
                     {"rest_depth", std::to_string(grid.rest_depth)},
                     {"brick_level", std::to_string(grid.brick_level)}};
  BakeTable grid_table{"grid", {}, {}}, brick_table{"bricks", {}, {}}, node_table{"nodes", {}, {}};
  BakeTable count_table{"level_counts", {}, {}}, sum_table{"sums", {}, {}}, material_table{"sum_materials", {}, {}};
  auto& numbers = grid_table.floats["bounds"];
  numbers = {static_cast<float>(grid.corner.x), static_cast<float>(grid.corner.y), static_cast<float>(grid.corner.z),
             static_cast<float>(grid.side_m)};
  append_bounds(&numbers, grid.core);
  for (const Bounds& box : grid.fine) append_bounds(&numbers, box);
  auto& masks = node_table.integers["mask"];
  auto& planes = node_table.integers["plane"];
  auto& colors = node_table.integers["color"];
  auto& triangles = node_table.integers["triangle"];
  for (const auto& [code, entry] : bricks.bricks) {
    brick_table.integers["code"].push_back(code);
    brick_table.integers["key_low"].push_back(static_cast<std::uint32_t>(entry.key));
    brick_table.integers["key_high"].push_back(static_cast<std::uint32_t>(entry.key >> 32));
    auto counts = entry.brick.counts;
    counts.resize(kLevels, 0u);
    auto& all_counts = count_table.integers["counts"];
    all_counts.insert(all_counts.end(), counts.begin(), counts.end());
    append_sums(entry.brick.sums, &sum_table.floats["sums"], &material_table.integers["materials"]);
    masks.insert(masks.end(), entry.brick.masks.begin(), entry.brick.masks.end());
    for (const OctreeWords& w : entry.brick.words) {
      planes.push_back(w.plane);
      colors.push_back(w.color);
      triangles.push_back(w.triangle);
    }
  }
  // The columns exist even for an empty octree.
  for (const char* name : {"code", "key_low", "key_high"}) brick_table.integers[name];
  count_table.integers["counts"];
  sum_table.floats["sums"];
  material_table.integers["materials"];
  file.tables = {std::move(grid_table), std::move(brick_table),    std::move(count_table),
                 std::move(sum_table),  std::move(material_table), std::move(node_table)};
  save_bake_file(path, file);
}

OctreeFile load_octree_file(const std::string& path) {
  const BakeFile file = load_bake_file(path);
  const auto kind = file.attributes.find("kind");
  if (kind == file.attributes.end() || kind->second != kOctreeKind) throw Error(path, "the bake is not an octree");
  whole_number(path, file, "version", kOctreeVersion, kOctreeVersion);
  OctreeFile out;
  OctreeGrid& grid = out.bricks.grid;
  grid.depth = whole_number(path, file, "depth", 0, kOctreeMaxLevels);
  grid.detail = whole_number(path, file, "detail", 0, std::min(kOctreeMaxDetail, grid.depth));
  grid.rest_depth = whole_number(path, file, "rest_depth", 0, grid.depth);
  grid.brick_level = whole_number(path, file, "brick_level", 0, grid.depth);
  out.complete = whole_number(path, file, "complete", 0, 1) == 1;
  if (const auto scene = file.attributes.find("scene"); scene != file.attributes.end()) out.scene = scene->second;
  const auto& numbers = file.floats(path, "grid", "bounds");
  const auto& codes = file.integers(path, "bricks", "code");
  const auto& low = file.integers(path, "bricks", "key_low");
  const auto& high = file.integers(path, "bricks", "key_high");
  const auto& counts = file.integers(path, "level_counts", "counts");
  const auto& materials = file.integers(path, "sum_materials", "materials");
  const auto& sums = file.floats(path, "sums", "sums");
  const auto& masks = file.integers(path, "nodes", "mask");
  const auto& planes = file.integers(path, "nodes", "plane");
  const auto& colors = file.integers(path, "nodes", "color");
  const auto& triangles = file.integers(path, "nodes", "triangle");
  const Error inconsistent(path, "the octree's tables do not fit together", "bake it again");
  if (numbers.size() < 10 || (numbers.size() - 10) % 6 != 0 || low.size() != codes.size() ||
      high.size() != codes.size() || counts.size() != codes.size() * kLevels ||
      materials.size() != codes.size() * 2 * OctreeSums::kMaterials || sums.size() != codes.size() * kSumFloats ||
      planes.size() != masks.size() || colors.size() != masks.size() || triangles.size() != masks.size())
    throw inconsistent;
  grid.corner = glm::dvec3(numbers[0], numbers[1], numbers[2]);
  grid.side_m = static_cast<double>(numbers[3]);
  grid.core = read_bounds(&numbers[4]);
  for (std::size_t i = 10; i < numbers.size(); i += 6) grid.fine.push_back(read_bounds(&numbers[i]));
  std::size_t node = 0;
  for (std::size_t b = 0; b < codes.size(); ++b) {
    OctreeBricks::Entry entry;
    entry.key = low[b] | std::uint64_t{high[b]} << 32;
    std::size_t expected = 1, total = 0;
    for (int level = 0; level <= grid.depth - grid.brick_level; ++level) {
      const std::uint32_t count = counts[b * kLevels + static_cast<std::size_t>(level)];
      if (level == 0 && count == 0u) break;
      if (count != expected || node + count > masks.size()) throw inconsistent;
      entry.brick.counts.push_back(count);
      expected = 0;
      for (std::uint32_t k = 0; k < count; ++k, ++node, ++total) {
        if (masks[node] > 255u) throw inconsistent;
        entry.brick.masks.push_back(static_cast<std::uint8_t>(masks[node]));
        entry.brick.words.push_back({planes[node], colors[node], triangles[node]});
        expected += static_cast<std::size_t>(std::popcount(masks[node]));
      }
    }
    if (total > 0 && expected != 0) throw inconsistent;
    entry.brick.sums = read_sums(&sums[b * kSumFloats], &materials[b * 2 * OctreeSums::kMaterials]);
    if (codes[b] >> 3 * grid.brick_level != 0u) throw inconsistent;
    out.bricks.bricks.emplace(codes[b], std::move(entry));
  }
  if (node != masks.size()) throw inconsistent;
  return out;
}

std::string octree_file_path(const std::string& folder, const std::string& scene, int depth) {
  if (!folder.empty()) return (std::filesystem::path(folder) / "octree.exr").string();
  const auto cache = cache_folder();
  if (!cache) return {};
  const std::uint64_t name = content_hash(std::as_bytes(std::span(scene)), static_cast<std::uint64_t>(depth));
  char text[48];
  std::snprintf(text, sizeof text, "octree-%016llx.exr", static_cast<unsigned long long>(name));
  return (*cache / text).string();
}

}  // namespace maquette
