#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/prt/transfer_bake.h"

namespace maquette {

/// The matrices of one block: the mean's, or those of one view.
using TransferBlock = std::vector<TransferMatrix>;

std::string transfer_manifest_path(const std::string& folder);
std::string transfer_block_path(const std::string& folder, std::size_t block);

struct TransferManifest {
  TransferProvenance provenance;
  std::vector<glm::vec3> positions, occluders;
  std::size_t blocks = 0;
};
void save_transfer_manifest(const std::string& path, const TransferManifest& manifest);
/// Throws Error.
TransferManifest load_transfer_manifest(const std::string& path);

/// Key of a bake's blocks.
std::string transfer_key(const TransferProvenance& provenance);
void save_transfer_block(const std::string& path, const std::string& key, const TransferBlock& block);
/// `dimensions`: directions of the cube. Throws Error: damaged, or of another bake.
TransferBlock load_transfer_block(const std::string& path, const std::string& key, std::size_t dimensions);

}  // namespace maquette
