#include "render/slf/texel_materials.h"

#include <algorithm>
#include <map>

#include "render/reference/path_scene.h"
#include "render/slf/incident.h"
#include "render/slf/outgoing.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

bool varies(const TracedMaterial& m, TextureRole role) { return m.texture(role) >= 0; }

/// Whether anything but the base colour changes from texel to texel.
bool only_base_color_varies(const TracedMaterial& m) {
  for (const TextureRole role :
       {TextureRole::metallic_roughness, TextureRole::clearcoat, TextureRole::clearcoat_roughness,
        TextureRole::specular, TextureRole::specular_color, TextureRole::sheen_color, TextureRole::sheen_roughness,
        TextureRole::iridescence, TextureRole::iridescence_thickness, TextureRole::transmission})
    if (varies(m, role)) return false;
  return true;
}

/// In the order of corners that the path tracer's geometry has.
glm::vec2 barycentric_of(const FlatGeometry& geometry, const AtlasSide& side, const glm::vec2& barycentric) {
  const float weights[3] = {1.0f - barycentric.x - barycentric.y, barycentric.x, barycentric.y};
  const std::uint32_t* corner = geometry.indices.data() + 3 * static_cast<std::size_t>(side.triangle);
  const auto weight_of = [&](std::uint32_t vertex) {
    return weights[std::find(side.vertices.begin(), side.vertices.end(), vertex) - side.vertices.begin()];
  };
  return {weight_of(corner[1]), weight_of(corner[2])};
}

}  // namespace

SurfacePoint point_of_texel(const PathScene& scene, const LightFieldAtlas& atlas, std::size_t t,
                            const std::vector<std::uint32_t>& traced_of, float texel_m) {
  const TexelFrame frame = frame_of_texel(scene.geometry, atlas, t);
  const AtlasTexel& texel = atlas.texels[t];
  const Ray ray{frame.position + frame.geometric, -frame.geometric};
  RayDifferential differential;
  const glm::vec3 x = frame.t * texel_m, y = frame.b * texel_m;
  differential = {ray.origin + x, ray.origin + y, ray.direction, ray.direction};
  const AtlasSide& side = atlas.sides[texel.side];
  const RayHit hit{1.0f, traced_of[side.triangle], barycentric_of(scene.geometry, side, texel.barycentric)};
  return resolve_surface(scene, ray, hit, {texel_m > 0.0f ? &differential : nullptr});
}

std::vector<std::uint32_t> traced_triangles(const PathScene& scene) {
  std::vector<std::uint32_t> traced_of(scene.triangles.size(), 0);
  for (std::uint32_t i = 0; i < scene.triangles.size(); ++i)
    if (scene.triangles[i].source < traced_of.size()) traced_of[scene.triangles[i].source] = i;
  return traced_of;
}

std::vector<TexelGroup> group_texels(const PathScene& scene, const LightFieldAtlas& atlas, float texel_m) {
  const std::vector<std::uint32_t> traced_of = traced_triangles(scene);
  std::vector<TexelGroup> groups;
  std::map<const TracedMaterial*, std::size_t> of_material;
  for (std::size_t t = 0; t < atlas.texels.size(); ++t) {
    const SurfacePoint p = point_of_texel(scene, atlas, t, traced_of, texel_m);
    const auto [found, fresh] = of_material.emplace(p.material, groups.size());
    if (fresh) {
      require_light_field_material(p.material->values);
      TexelGroup group;
      group.point = p;
      const bool changes = p.material->textured || p.material->colored;
      if (p.material->btf)
        group.kind = TexelGroup::Kind::btf;
      else if (!p.material->measured && changes)
        group.kind = only_base_color_varies(*p.material) && p.material->values.metallic == 0.0f
                         ? TexelGroup::Kind::base_linear
                         : TexelGroup::Kind::each;
      groups.push_back(group);
    }
    TexelGroup& group = groups[found->second];
    group.texels.push_back(static_cast<std::uint32_t>(t));
    group.scales.push_back(p.material->tabulated()                       ? p.tint
                           : group.kind == TexelGroup::Kind::base_linear ? p.base_color
                                                                         : glm::vec3(1.0f));
  }
  return groups;
}

BtfTexels place_btf_texels(const PathScene& scene, const LightFieldAtlas& atlas, std::span<const std::uint32_t> texels,
                           float texel_m) {
  const std::vector<std::uint32_t> traced_of = traced_triangles(scene);
  BtfTexels places{std::vector<BtfLookup>(texels.size()), std::vector<BtfTurn>(texels.size())};
  parallel_for(std::size_t{0}, texels.size(), [&](std::size_t i) {
    const SurfacePoint p = point_of_texel(scene, atlas, texels[i], traced_of, texel_m);
    const TexelFrame frame = frame_of_texel(scene.geometry, atlas, texels[i]);
    places.lookups[i] = p.btf;
    places.turns[i] = btf_turn(glm::vec2(frame.to_local(p.t)), glm::vec2(frame.to_local(p.b)));
  });
  return places;
}

}  // namespace maquette
