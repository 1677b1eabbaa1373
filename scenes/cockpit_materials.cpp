#include <algorithm>
#include <cmath>

#include "scenes/cockpit.h"
#include "scenes/cockpit_textures.h"

namespace maquette::builtin {

using namespace modelling;

namespace {

/// `emissive` in cd/m2: displays at their daylight setting, lamps as required by regulations.
Material emitter(const std::string& name, const glm::vec3& emissive) {
  Material material = plain_material(name, {0.02f, 0.02f, 0.02f}, 0.0f, 0.3f);
  material.emissive = emissive;
  return material;
}

Material screen(const std::string& name, int image, float brightness) {
  Material material = emitter(name, glm::vec3(brightness));
  material.roughness = 0.08f;
  material.emissive_texture.image = image;
  material.emissive_texture.wrap_s = material.emissive_texture.wrap_t = Wrap::clamp_to_edge;
  return material;
}

Material pane(const std::string& name, const glm::vec3& tint) {
  Material material = plain_material(name, tint, 0.0f, 0.0f);
  material.transmission = 1.0f;
  material.ior = 1.52f;
  material.glass = true;
  material.double_sided = true;
  return material;
}

void add_paints_and_trims(SceneBuilder* builder, CockpitMaterials* m) {
  const auto measured = [&](const char* name, const char* library, const glm::vec3& base, float metallic, float rough) {
    return builder->add_material(measured_material(name, library, base, metallic, rough));
  };
  m->paint = measured("Paint", "paint-red-metallic", srgb(150, 14, 22), 0.5f, 0.32f);
  m->paint_touring = measured("PaintTouring", "paint-blue-metallic", srgb(18, 44, 110), 0.5f, 0.32f);
  m->paint_atelier = measured("PaintAtelier", "paint-pearl-white", srgb(226, 224, 216), 0.1f, 0.32f);
  m->seat = measured("Seat", "leather-tan", srgb(158, 104, 62), 0.0f, 0.55f);
  m->seat_touring = measured("SeatTouring", "leather-black", srgb(38, 37, 37), 0.0f, 0.55f);
  m->seat_atelier = measured("SeatAtelier", "fabric-grey", srgb(122, 122, 124), 0.0f, 0.9f);
  m->insert = measured("SeatInsert", "leather-tan", srgb(150, 96, 56), 0.0f, 0.6f);
  m->insert_touring = measured("SeatInsertTouring", "fabric-grey", srgb(112, 112, 114), 0.0f, 0.9f);
  m->insert_atelier = measured("SeatInsertAtelier", "leather-black", srgb(38, 37, 37), 0.0f, 0.6f);
  m->trim = measured("Trim", "leather-tan", srgb(150, 98, 58), 0.0f, 0.6f);
  m->trim_touring = measured("TrimTouring", "leather-black", srgb(36, 35, 35), 0.0f, 0.6f);
  m->trim_atelier = measured("TrimAtelier", "fabric-grey", srgb(118, 118, 120), 0.0f, 0.9f);
  m->decor = measured("Decor", "metal-brushed", srgb(178, 178, 180), 1.0f, 0.35f);
  m->decor_touring = measured("DecorTouring", "wood-satin", srgb(112, 66, 34), 0.0f, 0.4f);
  m->decor_atelier = measured("DecorAtelier", "plastic-piano-black", srgb(12, 12, 13), 0.0f, 0.08f);
  m->soft = measured("SoftTouch", "leather-black", srgb(34, 34, 35), 0.0f, 0.7f);
  m->hard = measured("Plastic", "plastic-matte-black", srgb(28, 28, 29), 0.0f, 0.6f);
  m->piano = measured("PianoBlack", "plastic-piano-black", srgb(10, 10, 11), 0.0f, 0.06f);
  m->chrome = measured("Chrome", "metal-chrome", srgb(215, 215, 218), 1.0f, 0.08f);
  m->brushed = measured("BrushedMetal", "metal-brushed", srgb(178, 178, 180), 1.0f, 0.35f);
  m->gunmetal = measured("Gunmetal", "metal-gunmetal", srgb(92, 94, 98), 1.0f, 0.35f);
  m->rubber = measured("Rubber", "rubber-black", srgb(24, 24, 24), 0.0f, 0.85f);
  m->carpet = measured("Carpet", "carpet-charcoal", srgb(44, 44, 46), 0.0f, 1.0f);
}

}  // namespace

CockpitMaterials add_cockpit_materials(SceneBuilder* builder) {
  CockpitMaterials m{};
  add_paints_and_trims(builder, &m);
  Material headliner = plain_material("Headliner", srgb(188, 185, 178), 0.0f, 0.95f);
  headliner.sheen_color = glm::vec3(0.12f);
  headliner.sheen_roughness = 0.6f;
  m.headliner = builder->add_material(headliner);
  m.stitch = builder->add_material(plain_material("Stitching", srgb(196, 60, 50), 0.0f, 0.8f));
  m.glass = builder->add_material(pane("Glass", {0.96f, 0.98f, 0.965f}));
  m.lens = builder->add_material(pane("LampLens", {0.97f, 0.97f, 0.97f}));
  m.mirror = builder->add_material(plain_material("Mirror", {0.9f, 0.9f, 0.91f}, 1.0f, 0.02f));
  m.cluster = builder->add_material(screen("ClusterDisplay", builder->add_image(make_cluster_image()), 2500.0f));
  m.center_screen = builder->add_material(screen("CenterDisplay", builder->add_image(make_center_image()), 1800.0f));
  m.ambient = builder->add_material(emitter("AmbientLight", {25.0f, 110.0f, 220.0f}));
  m.daylight_lamp = builder->add_material(emitter("DaylightLamp", {20000.0f, 20700.0f, 22000.0f}));
  Material tail = plain_material("TailLamp", srgb(140, 6, 10), 0.0f, 0.1f);
  tail.emissive = {1800.0f, 40.0f, 40.0f};
  tail.clearcoat = 1.0f;
  tail.clearcoat_roughness = 0.03f;
  m.tail_lamp = builder->add_material(tail);
  Material caliper = plain_material("Caliper", srgb(170, 20, 20), 0.0f, 0.35f);
  caliper.clearcoat = 1.0f;
  caliper.clearcoat_roughness = 0.05f;
  m.caliper = builder->add_material(caliper);
  m.disc = builder->add_material(plain_material("BrakeDisc", srgb(150, 150, 152), 1.0f, 0.4f));
  Material asphalt = plain_material("Ground", {1.0f, 1.0f, 1.0f}, 0.0f, 0.9f);
  asphalt.base_color_texture.image = builder->add_image(make_asphalt_image());
  m.asphalt = builder->add_material(asphalt);
  return m;
}

void add_variants(SceneBuilder* builder, const CockpitMaterials& m) {
  Scene& scene = builder->scene();
  scene.variants = {"Sport", "Touring", "Atelier"};
  const std::array<std::array<int, 3>, 5> families{{{m.paint, m.paint_touring, m.paint_atelier},
                                                    {m.seat, m.seat_touring, m.seat_atelier},
                                                    {m.insert, m.insert_touring, m.insert_atelier},
                                                    {m.trim, m.trim_touring, m.trim_atelier},
                                                    {m.decor, m.decor_touring, m.decor_atelier}}};
  for (Mesh& mesh : scene.meshes)
    for (Primitive& primitive : mesh.primitives)
      for (const std::array<int, 3>& family : families)
        if (primitive.material == family[0])
          for (int i = 0; i < 3; ++i) primitive.variant_materials[i] = family[static_cast<std::size_t>(i)];
}

}  // namespace maquette::builtin
