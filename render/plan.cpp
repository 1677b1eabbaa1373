#include "render/plan.h"

#include <algorithm>

#include "render/enclosure.h"
#include "render/reflections/reflectors.h"
#include "render/registry.h"
#include "scenes/error.h"

namespace maquette {

namespace {

bool has_texture(const Material& material) {
  for (const TextureRef* texture :
       {&material.base_color_texture, &material.metallic_roughness_texture, &material.normal_texture,
        &material.occlusion_texture, &material.emissive_texture, &material.clearcoat_texture,
        &material.clearcoat_roughness_texture, &material.clearcoat_normal_texture, &material.transmission_texture,
        &material.specular_texture, &material.specular_color_texture, &material.sheen_color_texture,
        &material.sheen_roughness_texture}) {
    if (*texture) return true;
  }
  return false;
}

bool is_emissive(const Material& material) { return material.emissive != glm::vec3(0.0f); }

/// Marks the materials that something visible uses; the last entry stands for glTF's default material.
std::vector<bool> used_materials(const Scene& scene, int variant) {
  std::vector<bool> used(scene.materials.size() + 1, false);
  const auto mark = [&](int material) {
    const bool named = material >= 0 && material < static_cast<int>(scene.materials.size());
    used[named ? static_cast<std::size_t>(material) : scene.materials.size()] = true;
  };
  for (const Node& node : scene.nodes) {
    if (!node.visible) continue;
    if (node.mesh >= 0) {
      for (const Primitive& primitive : scene.meshes[static_cast<std::size_t>(node.mesh)].primitives)
        mark(material_of(primitive, variant));
    }
    if (node.patch >= 0) mark(scene.patches[static_cast<std::size_t>(node.patch)].material);
  }
  return used;
}

/// Of find_reflectors without names, before it is known which materials mirror.
int count_reflectors(const Scene& scene, int variant) {
  const bool marks = marks_reflectors(scene);
  const auto counts = [&](const Node& node, int material) {
    const bool named = material >= 0 && material < static_cast<int>(scene.materials.size());
    return reflects_unnamed(scene, node, marks, named && scene.materials[static_cast<std::size_t>(material)].glass);
  };
  int count = 0;
  for (const Node& node : scene.nodes) {
    if (!node.visible) continue;
    if (node.patch >= 0) count += counts(node, scene.patches[static_cast<std::size_t>(node.patch)].material);
    if (node.mesh < 0) continue;
    for (const Primitive& primitive : scene.meshes[static_cast<std::size_t>(node.mesh)].primitives)
      count += counts(node, material_of(primitive, variant));
  }
  return count;
}

std::string decide_visibility(const SceneFacts& facts, const std::string& mode, const std::string& asked,
                              FramePlan* plan) {
  if (mode == "reference") return "none";  // its own rays; add_passes says so
  if (mode != "uniform" && mode != "bandwidth") {
    plan->left_out.push_back({"visibility", "mode " + mode + " knows none"});
    return "none";
  }
  if (asked == "traced") {
    plan->passes.push_back({"visibility", "shading.visibility is traced: the samples' rays go through the octree"});
    return "traced";
  }
  if (asked == "baked" || (asked == "auto" && facts.enclosed)) {
    plan->passes.push_back(
        {"visibility", asked == "baked" ? "shading.visibility is baked"
                                        : "the scene closes the eye in: without it light comes through the roof"});
    return "baked";
  }
  plan->left_out.push_back(
      {"visibility", asked == "none" ? "shading.visibility is none" : "the scene does not close the eye in"});
  return "none";
}

/// Light by way of other surfaces fills what the sky's shadows leave black; without shadows there is nothing to fill.
std::string decide_indirect(const FramePlan& plan, const std::string& asked, std::vector<LeftOut>* left_out) {
  if (plan.mode == "reference") return "none";  // traces it
  std::string why;
  if (plan.mode != "uniform" && plan.mode != "bandwidth")
    why = "mode " + plan.mode + " knows none";
  else if (asked == "none")
    why = "shading.indirect is none";
  else if (plan.visibility == "traced")
    why = "it goes with baked shadows, and shading.visibility is traced";
  else if (plan.visibility != "baked")
    why = "nothing shadows the sky, so there is nothing that it would fill";
  if (why.empty()) return "baked";
  left_out->push_back({"indirect", why});
  return "none";
}

void decide_reflections(const SceneFacts& facts, const ViewInfo& view, FramePlan* plan) {
  const TechniqueInfo* technique = find_reflector_technique(view.reflections);
  const int reflectors = view.reflectors >= 0 ? view.reflectors : facts.reflector_count;
  const int seen = view.reflectors_in_view >= 0 ? view.reflectors_in_view : reflectors;
  if (!technique) {
    plan->left_out.push_back({"reflections", "--reflections off"});
  } else if (plan->mode == "reference") {
    plan->left_out.push_back({"reflections", "mode reference follows the mirrored paths itself"});
  } else if (reflectors == 0) {
    plan->left_out.push_back(
        {"reflections", "the scene marks no reflector and has no pane of glass; name a mirror with --reflector"});
  } else if (seen == 0) {
    plan->left_out.push_back({"reflections", "no reflector is in view"});
  } else {
    plan->reflections = view.reflections;
    plan->passes.push_back({"reflections", std::to_string(seen) + " of " + std::to_string(reflectors) +
                                               " reflectors may be seen, technique " + view.reflections});
  }
}

/// Mirrored light of other surfaces takes the place of what is baked of it, and fills what shadows leave black.
void decide_glossy(const SceneFacts& facts, const Settings& settings, const ViewInfo& view, FramePlan* plan) {
  const double roughness = settings.get_double("octree.glossy");
  const bool known = view.glossy_in_view >= 0, none_wanted = roughness == 0.0 && view.glossy_in_view <= 0;
  const bool any =
      known ? view.glossy_in_view > 0 : roughness > 0.0 && static_cast<double>(facts.least_roughness) <= roughness;
  std::string why;
  if (plan->mode == "reference")
    why = "mode reference follows the mirrored paths itself";
  else if (view.reflections != "octree")
    why = "only the reflector technique octree has cells for them";
  else if (none_wanted)
    why = "octree.glossy is 0, and no such part is named with --reflector";
  else if (plan->mode != "uniform" && plan->mode != "bandwidth")
    why = "mode " + plan->mode + " knows no shadows, so the sky shines where surfaces would be mirrored";
  else if (settings.get_string("shading.indirect") == "none")
    why = "shading.indirect is none";
  else if (plan->visibility == "none")
    why = "nothing shadows the sky, so it shines where surfaces would be mirrored";
  else if (!any)
    why = "no opaque surface in view is as smooth as octree.glossy asks";
  if (!why.empty()) {
    plan->left_out.push_back({"glossy", why});
    return;
  }
  plan->glossy = true;
  plan->passes.push_back({"glossy", (known ? std::to_string(view.glossy_in_view) + " glossy opaque surfaces may be seen"
                                           : std::string("glossy opaque surfaces may be seen")) +
                                        ": what they mirror of others is traced, " +
                                        settings.get_string("reflections.resolution") + " resolution"});
}

void check_request(const SceneFacts& facts, const TechniqueInfo& mode, const Settings& settings, const ViewInfo& view) {
  if (view.width < 1 || view.height < 1)
    throw UsageError("--size", "a picture needs at least one pixel, not " + std::to_string(view.width) + "x" +
                                   std::to_string(view.height));
  if (view.msaa != 1 && view.msaa != 4 && view.msaa != 16)
    throw UsageError("--msaa", std::to_string(view.msaa) + " samples a pixel are not offered", "use 1, 4 or 16");
  for (const TechniqueInfo& technique : techniques()) {
    if (!technique.check ||
        (technique.kind != TechniqueKind::shared && technique.name != mode.name && technique.name != view.reflections))
      continue;
    if (const std::optional<std::string> why = technique.check(facts, settings)) throw Error("", *why);
  }
}

}  // namespace

float least_roughness(const Material& material) {
  const float base = material.metallic_roughness_texture ? 0.0f : material.roughness;
  return material.clearcoat > 0.0f ? std::min(base, material.clearcoat_roughness) : base;
}

SceneFacts compute_facts(const Scene& scene, int variant) {
  SceneFacts facts;
  facts.triangle_count = count_triangles(scene);
  const std::vector<bool> used = used_materials(scene, variant);
  const Material default_material;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    const Material& material = i < scene.materials.size() ? scene.materials[i] : default_material;
    ++facts.material_count;
    ++(material.measured.empty() ? facts.analytic_count : facts.measured_count);
    facts.has_textures |= has_texture(material);
    facts.has_normal_maps |=
        static_cast<bool>(material.normal_texture) || static_cast<bool>(material.clearcoat_normal_texture);
    facts.has_mask |= material.alpha_mode == AlphaMode::mask;
    facts.has_glass |= material.glass || material.alpha_mode == AlphaMode::blend;
    facts.has_sheen |= material.measured.empty() && material.sheen_color != glm::vec3(0.0f);
    facts.has_clearcoat |= material.measured.empty() && material.clearcoat > 0.0f;
    facts.has_emissive_meshes |= is_emissive(material);
    if (!material.glass && material.alpha_mode != AlphaMode::blend)
      facts.least_roughness =
          std::min(facts.least_roughness, material.measured.empty() ? least_roughness(material) : 0.0f);
  }
  facts.reflector_count = count_reflectors(scene, variant);
  for (const Node& node : scene.nodes) {
    if (!node.visible) continue;
    facts.has_punctual_lights |= node.light >= 0;
    facts.has_subdivision |= node.mesh >= 0 && scene.meshes[static_cast<std::size_t>(node.mesh)].cage != nullptr;
  }
  facts.enclosed = is_enclosed(scene, variant);
  return facts;
}

FramePlan plan(const SceneFacts& facts, const std::string& mode_name, const Settings& settings, const ViewInfo& view) {
  const TechniqueInfo& mode = find_mode(mode_name);
  check_request(facts, mode, settings, view);
  FramePlan plan;
  plan.mode = mode_name;
  plan.msaa = view.msaa;
  const bool shines = facts.has_punctual_lights || facts.has_emissive_meshes;
  const bool traced = mode_name == "reference";
  plan.lights = shines && (mode_name == "uniform" || mode_name == "bandwidth" || traced);
  decide_reflections(facts, view, &plan);
  plan.sheen = facts.has_sheen;
  plan.clearcoat = facts.has_clearcoat;
  plan.glass = facts.has_glass || (!plan.reflections.empty() && view.mirrors);
  if (traced) {
    mode.add_passes(facts, settings, view, &plan);
  } else {
    plan.passes.push_back(
        {"raster", std::to_string(facts.triangle_count) + " triangles: only their numbers and depth"});
    plan.passes.push_back(
        {"gbuffer", "normals, texture coordinates and curvature of what is visible, found on screen"});
  }
  plan.visibility = decide_visibility(facts, mode_name, settings.get_string("shading.visibility"), &plan);
  plan.indirect = decide_indirect(plan, settings.get_string("shading.indirect"), &plan.left_out);
  if (plan.lights) {
    plan.passes.push_back({"lights", facts.has_emissive_meshes ? "emissive surfaces light the scene"
                                                               : "the scene has lights of its own"});
  } else if (shines) {
    plan.left_out.push_back({"lights", "mode " + mode_name + " knows the environment only"});
  } else {
    plan.left_out.push_back({"lights", "the scene has no lights and nothing that glows"});
  }
  if (!traced) mode.add_passes(facts, settings, view, &plan);
  if (plan.indirect == "baked")
    plan.passes.push_back({"indirect", "what sees no sky is lit by other surfaces: baked per vertex, all bounces"});
  decide_glossy(facts, settings, view, &plan);
  if (!plan.reflections.empty()) find_reflector_technique(plan.reflections)->add_passes(facts, settings, view, &plan);
  if (plan.glass)
    plan.passes.push_back(
        {"glass", traced ? "panes mirror and let pass what rays find" : "panes and blended surfaces, back to front"});
  else
    plan.left_out.push_back({"glass", "no material transmits or blends"});
  if (view.msaa > 1)
    plan.passes.push_back({"multisampling", std::to_string(view.msaa) + " samples a pixel were asked for"});
  else
    plan.left_out.push_back({"multisampling", "one sample a pixel was asked for"});
  plan.passes.push_back({"compose", "the sky where nothing is hit, and the average with the frames before"});
  if (!facts.has_normal_maps) plan.left_out.push_back({"normal_maps", "no material has one"});
  if (!facts.has_mask) plan.left_out.push_back({"alpha_mask", "no material is cut out"});
  if (facts.measured_count == 0) plan.left_out.push_back({"measured_materials", "every material is analytic"});
  if (!facts.has_sheen) plan.left_out.push_back({"sheen", "no material without a table has it"});
  if (!facts.has_clearcoat) plan.left_out.push_back({"clearcoat", "no material without a table has it"});
  if (!facts.has_subdivision) plan.left_out.push_back({"subdivision", "no mesh has a control cage"});
  if (plan.visibility == "traced")
    plan.passes.push_back({"octree", "shading.visibility is traced"});
  else if (plan.reflections == "octree")
    plan.passes.push_back({"octree", "the reflectors' rays go through it"});
  else if (plan.glossy)
    plan.passes.push_back({"octree", "the mirrored rays of glossy surfaces go through it"});
  else
    plan.left_out.push_back({"octree", "neither shading.visibility=traced nor a reflector technique asks for one"});
  if ((plan.reflections == "octree" || plan.glossy) && settings.get_string("octree.brdf") != "none")
    plan.passes.push_back({"cell_brdfs", "octree.brdf is " + settings.get_string("octree.brdf")});
  return plan;
}

}  // namespace maquette
