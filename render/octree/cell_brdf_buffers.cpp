#include "render/octree/cell_brdf_buffers.h"

#include <bit>
#include <glm/gtc/packing.hpp>

#include "render/gl/bindings.h"
#include "render/octree/cell_brdf_bake.h"
#include "render/octree/octree_shared.h"

namespace maquette {

namespace {

constexpr int kTerms = 5;  // mean and components

std::uint64_t half4(const glm::vec4& v) { return glm::packHalf4x16(v); }

}  // namespace

CellBrdfBuffers::CellBrdfBuffers(const CellBrdfIndex& index, const LocalPca& pca) {
  std::vector<glm::uvec4> codes;
  for (const CellBrdfCode& c : index.table)
    codes.emplace_back(
        c.cluster | c.turn.steps << 16 | (c.turn.mirrored ? 0x40000000u : 0u) | (c.shared ? 0x80000000u : 0u),
        glm::packHalf2x16({c.weights[0], c.weights[1]}), glm::packHalf2x16({c.weights[2], c.weights[3]}),
        std::bit_cast<std::uint32_t>(c.scale));
  if (codes.empty()) codes.emplace_back(0u);
  // Of each cluster and pair: mean and components side by side, so that one lookup is one line of memory.
  std::vector<std::uint64_t> pairs;
  std::vector<float> seen;
  for (int k = 0; k < pca.cluster_count(); ++k) {
    const Eigen::VectorXf mean = pca.mean(k);
    const Eigen::MatrixXf basis = pca.components(k);
    const auto value = [&](Eigen::Index row, int term) {
      return term == 0 ? mean[row] : term - 1 < basis.cols() ? basis(row, term - 1) : 0.0f;
    };
    for (Eigen::Index pair = 0; pair < shared::kCellPairs; ++pair)
      for (int term = 0; term < kTerms; ++term)
        pairs.push_back(half4({value(3 * pair, term), value(3 * pair + 1, term), value(3 * pair + 2, term), 0.0f}));
    for (Eigen::Index d = 0; d < shared::kCellDirections; ++d)
      for (int term = 0; term < kTerms; ++term) seen.push_back(value(3 * shared::kCellPairs + d, term));
  }
  if (pairs.empty()) pairs.push_back(0), seen.push_back(0.0f);
  nodes_ = Buffer::from("cell BRDFs of nodes", index.codes.empty() ? std::vector<std::uint32_t>{0u} : index.codes);
  codes_ = Buffer::from("cell BRDF codes", codes);
  pairs_ = Buffer::from("cell BRDF pairs", pairs);
  seen_ = Buffer::from("cell BRDF areas", seen);
  node_view_ = Texture::make_buffer("cell BRDFs of nodes", GL_R32UI, nodes_);
  code_view_ = Texture::make_buffer("cell BRDF codes", GL_RGBA32UI, codes_);
  pair_view_ = Texture::make_buffer("cell BRDF pairs", GL_RGBA16F, pairs_);
  seen_view_ = Texture::make_buffer("cell BRDF areas", GL_R32F, seen_);
}

void CellBrdfBuffers::bind() const {
  glBindTextureUnit(kUnitCellOfNode, node_view_.get());
  glBindTextureUnit(kUnitCellCodes, code_view_.get());
  glBindTextureUnit(kUnitCellPairs, pair_view_.get());
  glBindTextureUnit(kUnitCellSeen, seen_view_.get());
}

}  // namespace maquette
