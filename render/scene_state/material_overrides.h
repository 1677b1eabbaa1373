#pragma once

#include <glm/glm.hpp>
#include <map>
#include <string>
#include <vector>

#include "scenes/scene.h"

namespace maquette {

/// The materials as they are drawn: with overrides from `sources` (material name or `*` -> MERL path, `builtin:NAME` or
/// `builtin:glass`), blended ones that cover everything as opaque ones, and unlit ones without what they do not show.
std::vector<Material> effective_materials(const Scene& scene, const std::map<std::string, std::string>& sources);

/// Cut out everywhere: the other factors of its alpha are at most 1.
bool is_cut_away(const Material& material);

/// Natural logarithm of what a material's volume absorbs per channel over its thickness in the mesh's space; 0 without
/// a volume. Source: KHR_materials_volume.
glm::vec3 volume_absorption(const Material& material);

/// Share of a material that is a pane of glass, before its textures; the rest is an opaque surface. Metal transmits
/// nothing. With `builtin:glass` or `extras` the factor itself may be 0.
float pane_share(const Material& material);

/// Whether the coat's normal texture has other coordinates than the normal texture, by which tangents are computed:
/// then it needs tangents of its own, where the file has none. Source: glTF 2.0, 3.7.2.1: those of "the texture
/// coordinates associated with the normal texture", which are transformed ones (KHR_texture_transform).
bool has_own_coat_tangents(const Material& material);

/// Whether the faces of a pane of it reflect as its refractive index alone says (KHR_materials_specular, and an index
/// of 0, say otherwise).
bool has_plain_faces(const Material& material);

/// Whether a share of a transparent material is a surface: coverage by alpha, or what does not transmit.
bool is_partly_surface(const Material& material);

}  // namespace maquette
