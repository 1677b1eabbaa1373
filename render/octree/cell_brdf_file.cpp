#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "render/octree/cell_brdf_bake.h"
#include "scenes/bake_file.h"
#include "scenes/error.h"

namespace maquette {

namespace {

constexpr const char* kCellKind = "octree_brdf";
constexpr const char* kCellVersion = "3";
constexpr std::size_t kWeights = 4;
constexpr std::uint32_t kMirrored = 1u << CellRotation::kBits;  ///< flag in the column `turn`

bool has(const BakeFile& file, const std::string& name, const std::string& value) {
  const auto found = file.attributes.find(name);
  return found != file.attributes.end() && found->second == value;
}

}  // namespace

void save_cell_brdf_file(const std::string& path, const CellBrdfs& brdfs, const std::string& scene, bool complete) {
  BakeFile file;
  file.attributes = {{"kind", kCellKind},
                     {"version", kCellVersion},
                     {"scene", scene},
                     {"complete", complete ? "1" : "0"},
                     {"fit_loss", std::to_string(brdfs.fit_loss)}};
  BakeTable means{"means", {}, {}}, components{"components", {}, {}}, bricks{"bricks", {}, {}};
  BakeTable cells{"cells", {}, {}}, codes{"codes", {}, {}};
  for (int k = 0; k < brdfs.pca.cluster_count(); ++k) {
    const Eigen::VectorXf mean = brdfs.pca.mean(k);
    const Eigen::MatrixXf basis = brdfs.pca.components(k);
    auto& m = means.floats["value"];
    m.insert(m.end(), mean.data(), mean.data() + mean.size());
    auto& c = components.floats["value"];
    c.insert(c.end(), basis.data(), basis.data() + basis.size());
  }
  means.floats["value"], components.floats["value"];
  for (const char* name : {"code", "key_low", "key_high", "cells", "codes"}) bricks.integers[name];
  for (const char* name : {"node", "code"}) cells.integers[name];
  for (const char* name : {"cluster", "shared", "turn"}) codes.integers[name];
  for (const char* name : {"w0", "w1", "w2", "w3", "scale"}) codes.floats[name];
  for (const auto& [code, brick] : brdfs.bricks) {
    bricks.integers["code"].push_back(code);
    bricks.integers["key_low"].push_back(static_cast<std::uint32_t>(brick.key));
    bricks.integers["key_high"].push_back(static_cast<std::uint32_t>(brick.key >> 32));
    bricks.integers["cells"].push_back(static_cast<std::uint32_t>(brick.nodes.size()));
    bricks.integers["codes"].push_back(static_cast<std::uint32_t>(brick.table.size()));
    auto& nodes = cells.integers["node"];
    nodes.insert(nodes.end(), brick.nodes.begin(), brick.nodes.end());
    auto& of_cell = cells.integers["code"];
    of_cell.insert(of_cell.end(), brick.codes.begin(), brick.codes.end());
    for (const CellBrdfCode& c : brick.table) {
      codes.integers["cluster"].push_back(c.cluster);
      codes.integers["shared"].push_back(c.shared);
      codes.integers["turn"].push_back(c.turn.steps | (c.turn.mirrored ? kMirrored : 0u));
      codes.floats["scale"].push_back(c.scale);
      for (std::size_t w = 0; w < kWeights; ++w) codes.floats["w" + std::to_string(w)].push_back(c.weights[w]);
    }
  }
  file.tables = {std::move(means), std::move(components), std::move(bricks), std::move(cells), std::move(codes)};
  save_bake_file(path, file);
}

CellBrdfFile load_cell_brdf_file(const std::string& path) {
  const BakeFile file = load_bake_file(path);
  if (!has(file, "kind", kCellKind)) throw Error(path, "the bake holds no cell BRDFs");
  if (!has(file, "version", kCellVersion))
    throw Error(path, "the cell BRDFs are of another version", "bake them again");
  const Error inconsistent(path, "the tables of the cell BRDFs do not fit together", "bake them again");
  const auto& means = file.floats(path, "means", "value");
  const auto& components = file.floats(path, "components", "value");
  const std::size_t clusters = means.size() / kCellBrdfDimension;
  if (means.size() % kCellBrdfDimension != 0 || components.size() != kWeights * means.size()) throw inconsistent;
  CellBrdfFile out;
  out.complete = has(file, "complete", "1");
  if (const auto loss = file.attributes.find("fit_loss"); loss != file.attributes.end())
    out.brdfs.fit_loss = std::clamp(std::atof(loss->second.c_str()), 0.0, 1.0);
  const auto columns = static_cast<Eigen::Index>(clusters);
  if (clusters > 0)
    out.brdfs.pca = LocalPca::restore(
        cell_brdf_measure(), Eigen::Map<const Eigen::MatrixXf>(means.data(), kCellBrdfDimension, columns),
        Eigen::Map<const Eigen::MatrixXf>(components.data(), kCellBrdfDimension, columns * Eigen::Index{kWeights}));
  const auto& brick_codes = file.integers(path, "bricks", "code");
  const auto& low = file.integers(path, "bricks", "key_low");
  const auto& high = file.integers(path, "bricks", "key_high");
  const auto& cell_counts = file.integers(path, "bricks", "cells");
  const auto& code_counts = file.integers(path, "bricks", "codes");
  const auto& nodes = file.integers(path, "cells", "node");
  const auto& codes = file.integers(path, "cells", "code");
  const auto& cluster = file.integers(path, "codes", "cluster");
  const auto& shared = file.integers(path, "codes", "shared");
  const auto& turns = file.integers(path, "codes", "turn");
  const auto& scales = file.floats(path, "codes", "scale");
  std::array<const std::vector<float>*, kWeights> weights{};
  for (std::size_t w = 0; w < kWeights; ++w) {
    weights[w] = &file.floats(path, "codes", "w" + std::to_string(w));
    if (weights[w]->size() != cluster.size()) throw inconsistent;
  }
  if (nodes.size() != codes.size() || shared.size() != cluster.size() || scales.size() != cluster.size() ||
      turns.size() != cluster.size())
    throw inconsistent;
  std::size_t cell = 0, code = 0;
  for (std::size_t b = 0; b < brick_codes.size(); ++b) {
    CellBrdfs::Brick brick;
    brick.key = low[b] | std::uint64_t{high[b]} << 32;
    if (cell + cell_counts[b] > nodes.size() || code + code_counts[b] > cluster.size()) throw inconsistent;
    for (std::uint32_t k = 0; k < cell_counts[b]; ++k, ++cell) {
      if (codes[cell] >= code_counts[b]) throw inconsistent;
      brick.nodes.push_back(nodes[cell]);
      brick.codes.push_back(codes[cell]);
    }
    for (std::uint32_t k = 0; k < code_counts[b]; ++k, ++code) {
      if (cluster[code] >= clusters) throw inconsistent;
      brick.table.push_back({cluster[code],
                             {(*weights[0])[code], (*weights[1])[code], (*weights[2])[code], (*weights[3])[code]},
                             scales[code],
                             {turns[code] % kMirrored, (turns[code] & kMirrored) != 0u},
                             shared[code] != 0u});
    }
    out.brdfs.bricks.emplace(brick_codes[b], std::move(brick));
  }
  if (cell != nodes.size() || code != cluster.size()) throw inconsistent;
  return out;
}

std::string cell_brdf_file_path(const std::string& octree_path) {
  if (octree_path.empty()) return {};
  const std::filesystem::path path(octree_path);
  return (path.parent_path() / (path.stem().string() + "_brdf.exr")).string();
}

}  // namespace maquette
