#pragma once

#include <optional>

#include "render/slf/light_field.h"
#include "render/technique/point_report.h"

namespace maquette {

/// The texel of a point of a triangle; nothing where its side has none.
std::optional<std::size_t> texel_at(const LightFieldAtlas& atlas, const FlatGeometry& geometry, std::uint32_t triangle,
                                    bool back, const glm::vec3& position);

/// Lumispheres of a texel, as discs of parabolic maps (x right, y up): light that arrives, light that leaves as
/// computed and as it is drawn, and what they differ by; its place, cluster and weights. Computes outgoing light of
/// this texel anew. Throws Error.
PointReport describe_texel(const LightField& field, std::size_t texel);

}  // namespace maquette
