#pragma once

#include "render/scene_state/geometry.h"

namespace maquette {

/// Writes one item of `flatten` anew from a primitive of the same counts: vertex by vertex what `flatten` would write.
/// `scene`: whose materials tell what tangents follow.
void write_item(const Scene& scene, const Primitive& primitive, const glm::mat4& world_from_node, const DrawItem& item,
                FlatGeometry* geometry);

}  // namespace maquette
