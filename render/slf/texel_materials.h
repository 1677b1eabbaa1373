#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/reference/surface.h"
#include "render/slf/atlas.h"
#include "render/slf/btf_response.h"

namespace maquette {

/// Texels of one material.
struct TexelGroup {
  /// `scaled`: light times scale times response; `base_linear`: response over black plus scale times what white adds;
  /// `btf`: as scaled, with a response of each texel that its BTF's factors give; `each`: a response of each texel.
  enum class Kind { scaled, base_linear, each, btf } kind = Kind::scaled;
  SurfacePoint point;
  std::vector<std::uint32_t> texels;
  std::vector<glm::vec3> scales;
};

/// `texel_m`: textures are filtered over this; 0: not. Throws Error for a material that cannot be kept.
std::vector<TexelGroup> group_texels(const PathScene& scene, const LightFieldAtlas& atlas, float texel_m);

/// Index of the path tracer's triangle for each of the mesh's.
std::vector<std::uint32_t> traced_triangles(const PathScene& scene);
SurfacePoint point_of_texel(const PathScene& scene, const LightFieldAtlas& atlas, std::size_t texel,
                            const std::vector<std::uint32_t>& traced_of, float texel_m);

/// Where texels of a BTF read it, and how its frame lies in theirs.
struct BtfTexels {
  std::vector<BtfLookup> lookups;
  std::vector<BtfTurn> turns;
};
BtfTexels place_btf_texels(const PathScene& scene, const LightFieldAtlas& atlas, std::span<const std::uint32_t> texels,
                           float texel_m);

}  // namespace maquette
