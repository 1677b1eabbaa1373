#include "render/prt/transfer_files.h"

#include <cstdlib>
#include <filesystem>

#include "render/bake/bake_attributes.h"

namespace maquette {

namespace {

namespace fs = std::filesystem;

constexpr const char *kManifestKind = "prt", *kBlockKind = "prt-transfer", *kVersion = "2";

std::map<std::string, std::string> attributes_of(const TransferProvenance& p) {
  std::map<std::string, std::string> attributes{{"version", kVersion},
                                                {"scene", p.scene},
                                                {"geometry", hex(p.geometry)},
                                                {"occluders", hex(p.occluders)},
                                                {"materials", hex(p.materials)},
                                                {"shape", hex(p.shape)},
                                                {"faces", std::to_string(p.faces)},
                                                {"rays", std::to_string(p.rays)},
                                                {"clusters", std::to_string(p.clusters)},
                                                {"components", std::to_string(p.components)},
                                                {"btf_components", std::to_string(p.btf_components)}};
  if (p.btf_error > 0.0) {
    char text[40];
    std::snprintf(text, sizeof text, "%.17g", p.btf_error);
    attributes["btf_error"] = text;
  }
  if (p.bounces > 0) attributes["bounces"] = std::to_string(p.bounces);
  if (p.texel_clusters > 0) attributes["texel_clusters"] = std::to_string(p.texel_clusters);
  if (p.fit != 0) attributes["fit"] = hex(p.fit);
  return attributes;
}

std::size_t number(const std::string& path, const BakeFile& file, const std::string& name) {
  return std::strtoull(attribute(path, file, name).c_str(), nullptr, 10);
}

BakeTable table_of(const std::string& name, const std::vector<glm::vec3>& points) {
  BakeTable table{name, {}, {}};
  static constexpr const char* kNames[] = {"x", "y", "z"};
  for (int c = 0; c < 3; ++c) {
    auto& column = table.floats[kNames[c]];
    for (const glm::vec3& p : points) column.push_back(p[c]);
  }
  return table;
}

std::vector<glm::vec3> points_of(const std::string& path, const BakeFile& file, const std::string& name,
                                 std::size_t count) {
  const auto &x = file.floats(path, name, "x"), &y = file.floats(path, name, "y"), &z = file.floats(path, name, "z");
  if (x.size() < count) throw Error(path, "the table '" + name + "' is too short", "bake it again");
  std::vector<glm::vec3> points;
  for (std::size_t i = 0; i < count; ++i) points.emplace_back(x[i], y[i], z[i]);
  return points;
}

/// Two half floats a word.
std::vector<std::uint32_t> pack(const std::vector<std::uint16_t>& halves) {
  std::vector<std::uint32_t> words((halves.size() + 1) / 2, 0);
  for (std::size_t i = 0; i < halves.size(); ++i)
    words[i / 2] |= static_cast<std::uint32_t>(halves[i]) << (16 * (i % 2));
  return words;
}
std::vector<std::uint16_t> unpack(const std::string& path, const std::vector<std::uint32_t>& words, std::size_t count) {
  if (2 * words.size() < count) throw Error(path, "the block is too short", "bake it again");
  std::vector<std::uint16_t> halves(count);
  for (std::size_t i = 0; i < count; ++i) {
    halves[i] = static_cast<std::uint16_t>(words[i / 2] >> (16 * (i % 2)));
    if ((halves[i] & 0x7c00) == 0x7c00) throw Error(path, "a value is not finite", "bake it again");
  }
  return halves;
}

}  // namespace

std::string transfer_manifest_path(const std::string& folder) { return (fs::path(folder) / "bake.exr").string(); }

std::string transfer_block_path(const std::string& folder, std::size_t block) {
  char name[40];
  std::snprintf(name, sizeof name, "transfer-%05zu.exr", block);
  return (fs::path(folder) / name).string();
}

void save_transfer_manifest(const std::string& path, const TransferManifest& manifest) {
  BakeFile file;
  file.attributes = attributes_of(manifest.provenance);
  file.attributes["kind"] = kManifestKind;
  file.attributes["vertices"] = std::to_string(manifest.positions.size());
  file.attributes["occluder_points"] = std::to_string(manifest.occluders.size());
  file.attributes["blocks"] = std::to_string(manifest.blocks);
  file.tables = {table_of("vertices", manifest.positions), table_of("occluders", manifest.occluders)};
  save_bake_file(path, file);
}

TransferManifest load_transfer_manifest(const std::string& path) {
  const BakeFile file = load_bake_file(path);
  if (attribute(path, file, "kind") != kManifestKind) throw Error(path, "the bake is no radiance transfer");
  if (attribute(path, file, "version") != kVersion) throw Error(path, "the bake has another version", "bake it again");
  const auto hash = [&](const char* name) {
    return static_cast<std::uint64_t>(std::strtoull(attribute(path, file, name).c_str(), nullptr, 16));
  };
  const auto small = [&](const char* name) { return static_cast<int>(number(path, file, name)); };
  TransferManifest manifest;
  manifest.provenance = {
      attribute(path, file, "scene"),
      hash("geometry"),
      hash("occluders"),
      hash("materials"),
      hash("shape"),
      small("faces"),
      small("rays"),
      small("clusters"),
      small("components"),
      small("btf_components"),
      file.attributes.contains("bounces") ? small("bounces") : 0,
      file.attributes.contains("texel_clusters") ? small("texel_clusters") : 0,
      file.attributes.contains("btf_error") ? std::strtod(attribute(path, file, "btf_error").c_str(), nullptr) : 0.0,
      file.attributes.contains("fit") ? hash("fit") : 0};
  manifest.positions = points_of(path, file, "vertices", number(path, file, "vertices"));
  manifest.occluders = points_of(path, file, "occluders", number(path, file, "occluder_points"));
  manifest.blocks = number(path, file, "blocks");
  return manifest;
}

std::string transfer_key(const TransferProvenance& provenance) { return key_of_attributes(attributes_of(provenance)); }

void save_transfer_block(const std::string& path, const std::string& key, const TransferBlock& block) {
  BakeFile file;
  file.attributes = {{"kind", kBlockKind}, {"key", key}, {"matrices", std::to_string(block.size())}};
  for (std::size_t m = 0; m < block.size(); ++m) {
    const TransferMatrix& matrix = block[m];
    const std::string n = std::to_string(m);
    char error[40], energy[40];
    std::snprintf(error, sizeof error, "%.17g", matrix.error);
    std::snprintf(energy, sizeof energy, "%.17g", matrix.energy);
    file.attributes["clusters " + n] = std::to_string(matrix.clusters);
    file.attributes["components " + n] = std::to_string(matrix.components);
    if (matrix.weights.empty()) file.attributes["weights " + n] = "none";
    if (matrix.channels > 1) file.attributes["channels " + n] = std::to_string(matrix.channels);
    file.attributes["vertices " + n] = std::to_string(matrix.owner.size());
    file.attributes["error " + n] = error;
    file.attributes["energy " + n] = energy;
    BakeTable q{"q " + n, {{"halves", pack(matrix.q)}}, {}};
    BakeTable owner{"clusters " + n,
                    {{"cluster", {matrix.owner.begin(), matrix.owner.end()}}},
                    {{"squared error", {matrix.squares.begin(), matrix.squares.end()}}}};
    BakeTable weights{"weights " + n, {{"halves", pack(matrix.weights)}}, {}};
    file.tables.push_back(std::move(q));
    file.tables.push_back(std::move(owner));
    if (!matrix.weights.empty()) file.tables.push_back(std::move(weights));
  }
  save_bake_file(path, file);
}

TransferBlock load_transfer_block(const std::string& path, const std::string& key, std::size_t dimensions) {
  const BakeFile file = load_bake_file(path);
  if (attribute(path, file, "kind") != kBlockKind) throw Error(path, "the file holds no radiance transfer");
  if (attribute(path, file, "key") != key) throw Error(path, "the block is of another bake", "bake it again");
  TransferBlock block(number(path, file, "matrices"));
  for (std::size_t m = 0; m < block.size(); ++m) {
    TransferMatrix& matrix = block[m];
    const std::string n = std::to_string(m);
    matrix.clusters = static_cast<int>(number(path, file, "clusters " + n));
    matrix.components = static_cast<int>(number(path, file, "components " + n));
    if (file.attributes.contains("channels " + n))
      matrix.channels = static_cast<int>(number(path, file, "channels " + n));
    const std::size_t vertices = number(path, file, "vertices " + n);
    matrix.error = std::strtod(attribute(path, file, "error " + n).c_str(), nullptr);
    matrix.energy = std::strtod(attribute(path, file, "energy " + n).c_str(), nullptr);
    if (matrix.clusters < 1 || matrix.clusters > kMostTransferClusters || matrix.components < 0 ||
        matrix.components > kMostTransferComponents || (matrix.channels != 1 && matrix.channels != 3))
      throw Error(path, "the block has impossible counts", "bake it again");
    matrix.q = unpack(path, file.integers(path, "q " + n, "halves"),
                      matrix.rows() * dimensions * static_cast<std::size_t>(matrix.channels));
    const auto& owner = file.integers(path, "clusters " + n, "cluster");
    const auto& squares = file.floats(path, "clusters " + n, "squared error");
    if (owner.size() < vertices || squares.size() < vertices)
      throw Error(path, "the block is too short", "bake it again");
    matrix.squares.assign(squares.begin(), squares.begin() + static_cast<std::ptrdiff_t>(vertices));
    for (std::size_t v = 0; v < vertices; ++v) {
      if (owner[v] >= static_cast<std::uint32_t>(matrix.clusters))
        throw Error(path, "a vertex has no cluster", "bake it again");
      matrix.owner.push_back(static_cast<std::uint16_t>(owner[v]));
    }
    if (matrix.components > 0 && !file.attributes.contains("weights " + n))
      matrix.weights = unpack(path, file.integers(path, "weights " + n, "halves"),
                              vertices * static_cast<std::size_t>(matrix.components));
  }
  return block;
}

}  // namespace maquette
