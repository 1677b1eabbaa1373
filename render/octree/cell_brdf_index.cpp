// Around the bake of cell BRDFs: the materials that it reads, and what it made by the nodes of an octree.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "render/btf/btf_source.h"
#include "render/octree/cell_brdf_bake.h"
#include "scenes/files.h"
#include "scenes/parallel.h"

namespace maquette {

std::vector<CellMaterial> make_cell_materials(const std::vector<Material>& materials, CellTables* library) {
  std::vector<CellMaterial> result;
  for (const Material& m : materials) {
    std::shared_ptr<const BrdfTable> table;
    if (!m.measured.empty()) {
      auto& entry = (*library)[m.measured + " " + std::to_string(material_source_stamp(m.measured))];
      if (!entry) entry = std::make_shared<const BrdfTable>(load_material_table(m.measured));
      table = entry;
    }
    result.emplace_back(m, table);
  }
  result.emplace_back(Material{});
  parallel_for(std::size_t{0}, result.size(), [&](std::size_t i) { result[i].make_grid(); });
  return result;
}

std::vector<std::uint64_t> cell_material_contents(const std::vector<Material>& materials) {
  std::vector<std::uint64_t> contents;
  for (const Material& m : materials)
    contents.push_back(content_hash(std::as_bytes(std::span(m.measured)),
                                    CellMaterial(m).content() + material_source_stamp(m.measured)));
  contents.push_back(CellMaterial(Material{}).content());
  return contents;
}

CellBrdfIndex index_cell_brdfs(const CellBrdfs& brdfs, const OctreeBricks& bricks, const Octree& octree) {
  CellBrdfIndex index;
  index.codes.assign(octree.level_begin[static_cast<std::size_t>(octree.depth) + 1], 0u);
  auto next = octree.level_begin;  // per level: next node of the current brick
  for (const auto& [code, entry] : bricks.bricks) {
    std::vector<std::uint32_t> node_of;
    for (std::size_t l = 0; l < entry.brick.counts.size(); ++l) {
      std::uint32_t& first = next[static_cast<std::size_t>(bricks.grid.brick_level) + l];
      for (std::uint32_t k = 0; k < entry.brick.counts[l]; ++k) node_of.push_back(first++);
    }
    const auto found = brdfs.bricks.find(code);
    if (found == brdfs.bricks.end()) continue;
    const auto base = static_cast<std::uint32_t>(index.table.size());
    index.table.insert(index.table.end(), found->second.table.begin(), found->second.table.end());
    for (std::size_t k = 0; k < found->second.nodes.size(); ++k)
      if (found->second.nodes[k] < node_of.size())
        index.codes[node_of[found->second.nodes[k]]] = base + found->second.codes[k] + 1u;
  }
  return index;
}

}  // namespace maquette
