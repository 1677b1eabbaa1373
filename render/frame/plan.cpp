#include "render/frame/plan.h"

#include <algorithm>
#include <cstdio>

#include "render/bezier/patch_fit.h"
#include "render/frame/planning.h"
#include "render/frame/vocabulary.h"
#include "render/technique/registry.h"
#include "scenes/error.h"

namespace maquette {

namespace {

// --- reflections ---

void decide_reflections(const Planning& p, bool traces_picture) {
  const ViewInfo& view = p.in.view;
  const int reflectors = view.reflectors >= 0 ? view.reflectors : p.in.facts.reflector_count;
  const int seen = view.reflectors_in_view >= 0 ? view.reflectors_in_view : reflectors;
  if (!p.in.status.fitting.empty() && p.reflector && !traces_picture)
    p.leave_out("patch_fit",
                "patches are being fitted to " + p.in.status.fitting + ": " + percent_done(p.in.status.fit_progress),
                kStatus);
  if (!p.reflector) return p.leave_out("reflections", "--reflections off", "--reflections");
  if (traces_picture)
    return p.leave_out("reflections", "mode " + p.plan->layers[0].mode + " follows the mirrored paths itself", kMode);
  if (p.in.status.all_fitting) return p.leave_out("reflections", "their patches are not fitted yet", kStatus);
  if (reflectors == 0)
    return p.leave_out("reflections",
                       "the scene marks no reflector and has no pane of glass; name a mirror with --reflector", kScene);
  if (seen == 0) return p.leave_out("reflections", "no reflector is in view", kView);
  if (p.reflector->can.needs_eye && view.orthographic)
    return p.leave_out("reflections",
                       "technique " + p.reflector->name +
                           " projects from an eye, and the camera is orthographic: take one whose rays are traced",
                       kView);
  if (p.reflector->can.needs_octree && !p.in.status.octree.ready)
    return p.leave_out("reflections", "their octree is not built yet", kStatus);
  p.plan->reflections = p.reflector->name;
  p.feature("reflections", std::to_string(seen) + " of " + std::to_string(reflectors) +
                               " reflectors may be seen, technique " + p.reflector->name);
}

/// Mirrored light of other surfaces takes the place of what is baked of it, and fills what shadows leave black.
void decide_glossy(const Planning& p, const Technique& mode) {
  const Settings& settings = p.in.settings;
  const double roughness = settings.get_double("reflections.glossy");
  const int in_view = p.in.view.glossy_in_view;
  const ShadingPlan& shading = p.plan->layers.front();
  const bool any =
      in_view >= 0 ? in_view > 0 : roughness > 0.0 && static_cast<double>(p.in.facts.least_roughness) <= roughness;
  const auto leave_out = [&](const std::string& why, const std::string& by) { p.leave_out("glossy", why, by); };
  if (mode.can.traces_picture) return leave_out("mode " + mode.name + " follows the mirrored paths itself", kMode);
  if (!p.reflector || !p.reflector->make_glossy)
    return leave_out("only a reflector technique that follows single rays can follow theirs", "--reflections");
  if (roughness == 0.0 && in_view <= 0)
    return leave_out("reflections.glossy is 0, and no such part is named with --reflector", "reflections.glossy");
  if (!mode.can.shadows)
    return leave_out("mode " + mode.name + " knows no shadows, so the sky shines where surfaces would be mirrored",
                     kMode);
  if (settings.get_string("shading.indirect") == "none")
    return leave_out("shading.indirect is none", "shading.indirect");
  if (settings.get_string("shading.visibility") != "traced" && !wants_baked(p, mode))
    return leave_out("nothing shadows the sky, so it shines where surfaces would be mirrored", "shading.visibility");
  if (!any) return leave_out("no opaque surface in view is as smooth as reflections.glossy asks", kView);
  if (p.reflector->can.needs_octree && !p.in.status.octree.ready)
    return leave_out("its octree is not built yet", kStatus);
  if (shading.visibility == "none") return leave_out("it waits for the bake of visibility", kStatus);
  if (shading.visibility == "baked" && shading.indirect != "baked")
    return leave_out("it waits for the bake of indirect light", kStatus);
  p.plan->glossy = true;
}

void decide_octree(const Planning& p) {
  const bool traced = p.plan->any_layer_is_shadowed_by("traced");
  const bool reflected = !p.plan->reflections.empty() && p.reflector->can.needs_octree;
  const bool glossy = p.plan->glossy && p.reflector->can.needs_octree;
  p.plan->octree = traced || reflected || glossy;
  if (traced)
    p.feature(words::kOctree, "shading.visibility is traced");
  else if (reflected)
    p.feature(words::kOctree, "the reflectors' rays go through it");
  else if (glossy)
    p.feature(words::kOctree, "the mirrored rays of glossy surfaces go through it");
  else if (!p.in.status.octree.ready)
    p.leave_out(words::kOctree, not_ready("it is", p.in.status.octree), kStatus);
  else if (p.in.status.keeps_octree)
    p.leave_out(words::kOctree, "nothing in view goes through it; kept for some frames more", kView);
  else
    p.leave_out(words::kOctree, "neither shading.visibility=traced nor a reflector technique asks for one",
                "--reflections");
  if ((!reflected && !glossy) || p.in.settings.get_string("octree.brdf") == "none") return;
  if (!p.in.status.cell_brdfs.ready)
    return p.leave_out("cell_brdfs", "their bake is not ready yet: " + percent_done(p.in.status.cell_brdfs.progress),
                       kStatus);
  p.plan->cell_brdfs = true;
  p.feature("cell_brdfs", "octree.brdf is " + p.in.settings.get_string("octree.brdf"));
}

/// What the fits are worth, for those who look at the plan.
void note_fits(const Planning& p) {
  if (p.plan->reflections.empty() || !p.reflector->can.needs_patches) return;
  const auto joined = [](const std::vector<std::string>& lines) {
    std::string all;
    for (const std::string& line : lines) all += (all.empty() ? "" : ", ") + line;
    return all;
  };
  const std::string good = joined(p.in.status.fitted), bad = joined(p.in.status.misfitted);
  char tolerance[16];
  std::snprintf(tolerance, sizeof tolerance, "%.2g mm", 1e3 * kFitTolerance_m);
  if (!good.empty()) p.feature("patch_fit", "curved meshes get bicubic patches: " + good);
  if (!bad.empty())
    p.feature("patch_fit", std::string("patches miss these by more than ") + tolerance + ": " + bad +
                               "; where a pixel's own ray is far from theirs it is hatched, and another reflector "
                               "technique shows it");
}

// --- passes ---

void add_surface_passes(const Planning& p) {
  p.add({"raster",
         std::to_string(p.in.facts.triangle_count) + " triangles: only their numbers and depth",
         {},
         {"triangles"}});
  const bool parts = p.plan->layers.size() > 1;
  for (std::size_t k = 0; k < p.plan->layers.size(); ++k) {
    const ShadingPlan& shading = p.plan->layers[k];
    p.add({"gbuffer",
           "normals and materials, textures applied, of what is visible" +
               (parts ? ", of the parts that mode " + shading.mode + " shades" : std::string()),
           {"triangles"},
           {"surfaces"},
           static_cast<int>(k)});
  }
}

void add_reflection_passes(const Planning& p) {
  if (p.plan->reflections.empty()) return;
  p.add({"panes", "the reflectors in view and the mirrored ray of each of their pixels", {"surfaces"}, {"rays"}});
  if (p.in.status.follows_all_rays.empty())
    p.add({"skip",
           "mirrored rays that bring less than reflections.skip of what is seen through the pane",
           {"rays", "radiance"},
           {"rays"}});
  else
    p.leave_out("skip", p.in.status.follows_all_rays, "reflections.skip");
  p.reflector->add_passes(p.in, nullptr, p.plan);
  p.add({"reflected shade",
         p.reflector->can.hits_cells
             ? "the octree's cells that the mirrored rays hit, all by mode " + p.plan->layers[0].mode
             : std::string("what the mirrored rays hit, by the mode of the part that is hit"),
         {"hits"},
         {"reflections"}});
}

void add_picture_passes(const Planning& p, bool averages_points) {
  const bool several = p.in.view.msaa > 1, parts = p.plan->layers.size() > 1;
  const bool first = p.in.status.accumulated == 0;
  p.add(
      {"compose", "emission, indirect light and the sky where nothing is hit", {"surfaces", "radiance"}, {"picture"}});
  add_reflection_passes(p);
  if (p.in.facts.has_blended)
    p.add({"blended",
           "surfaces that let through what is behind them: layers from front to back, each shaded like opaque ones",
           {"triangles"},
           {"blended"}});
  if (p.plan->glass)
    p.add({"glass",
           "panes and blended surfaces, back to front",
           {"triangles", "picture", "reflections", "blended"},
           {"picture"}});
  else
    p.leave_out("glass", "no material transmits or blends", kScene);
  const bool averages_over_panes = p.plan->glass && !averages_points && !first;
  if (several || parts || averages_over_panes)
    p.add({"filter",
           several ? "the mean over a pixel's samples" : "the mean with the frames before",
           {"picture"},
           {"picture"}});
  if (several)
    p.feature("multisampling", std::to_string(p.in.view.msaa) + " samples a pixel were asked for");
  else
    p.leave_out("multisampling", "one sample a pixel was asked for", "--msaa");
}

void decide_details(const Planning& p) {
  const MaterialDetails& details = p.in.facts.details;
  p.plan->details = details.any;
  if (!details.any) {
    p.leave_out("surface_details", "no material has what it holds", kScene);
    return;
  }
  std::string what = "occlusion, textures of specular, sheen or the coat's roughness";
  if (details.anisotropy) what += ", anisotropy";
  if (details.coat_normal) what += ", the coat's own normals";
  if (details.film) what += ", iridescence";
  p.feature("surface_details", what);
}

void note_absent_features(const Planning& p) {
  const SceneFacts& facts = p.in.facts;
  if (!facts.has_normal_maps) p.leave_out("normal_maps", "no material has one", kScene);
  if (!facts.has_mask) p.leave_out("alpha_mask", "no material is cut out", kScene);
  if (facts.measured_count == 0) p.leave_out("measured_materials", "every material is analytic", kScene);
  if (!facts.has_sheen) p.leave_out("sheen", "no material without a table has it", kScene);
  if (!facts.has_clearcoat) p.leave_out("clearcoat", "no material without a table has it", kScene);
  if (!facts.has_subdivision) p.leave_out("subdivision", "no mesh has a control cage", kScene);
}

// --- the whole ---

void check_request(const SceneFacts& facts, const Settings& settings, const ViewInfo& view,
                   const std::vector<const Technique*>& used, const Registry& registry) {
  if (view.width < 1 || view.height < 1)
    throw UsageError("--size", "a picture needs at least one pixel, not " + std::to_string(view.width) + "x" +
                                   std::to_string(view.height));
  if (view.msaa != 1 && view.msaa != 4 && view.msaa != 16)
    throw UsageError("--msaa", std::to_string(view.msaa) + " samples a pixel are not offered", "use 1, 4 or 16");
  for (const Technique& technique : registry.techniques) {
    const bool asked =
        technique.kind == TechniqueKind::shared || std::find(used.begin(), used.end(), &technique) != used.end();
    if (!asked || !technique.check) continue;
    if (const std::optional<std::string> why = technique.check(facts, settings)) throw Error("", *why);
  }
}

/// The default mode's layer first, then one for each other mode that a part has.
std::vector<ShadingPlan> make_layers(const std::string& mode, const ViewInfo& view, const SceneFacts& facts,
                                     const Registry& registry) {
  std::vector<ShadingPlan> layers(1);
  layers[0].mode = mode;
  for (std::size_t k = 0; k < view.part_modes.size(); ++k) {
    const PartMode& part = view.part_modes[k];
    const Technique& technique = registry.find_mode(part.mode, "--mode-of");
    if (technique.can.traces_picture || registry.find_mode(mode).can.traces_picture)
      throw UsageError("--mode-of " + part.node + "=" + part.mode,
                       "mode " + (technique.can.traces_picture ? part.mode : mode) + " draws whole pictures",
                       "use it for all of the scene, without --mode-of");
    const auto replaces = [&](const PartMode& later) { return later.node == part.node && later.index == part.index; };
    if (std::any_of(view.part_modes.begin() + static_cast<std::ptrdiff_t>(k) + 1, view.part_modes.end(), replaces))
      continue;
    auto layer = std::find_if(layers.begin(), layers.end(), [&](const ShadingPlan& l) { return l.mode == part.mode; });
    if (layer == layers.end()) {
      layers.emplace_back().mode = part.mode;
      layer = std::prev(layers.end());
    }
    layer->nodes.push_back(part.node);
  }
  for (ShadingPlan& layer : layers) {
    layer.sheen = facts.has_sheen;
    layer.clearcoat = facts.has_clearcoat;
  }
  return layers;
}

void note_parts(const Planning& p) {
  for (const ShadingPlan& layer : p.plan->layers) {
    std::string nodes;
    for (const std::string& node : layer.nodes) nodes += (nodes.empty() ? "'" : ", '") + node + "'";
    if (!nodes.empty()) p.feature("parts", "mode " + layer.mode + " shades " + nodes + " and what is below");
  }
}

/// A whole picture by a mode's own rays.
void plan_traced_picture(const Planning& p, const Technique& mode) {
  decide_reflections(p, true);
  mode.add_passes(p.in, &p.plan->layers[0], p.plan);
  decide_lights(p, mode, &p.plan->layers[0]);
  decide_glossy(p, mode);
  p.plan->glass = p.in.facts.has_glass;
  if (p.plan->glass)
    p.feature("glass", "panes mirror and let pass what rays find");
  else
    p.leave_out("glass", "no material transmits or blends", kScene);
  if (p.in.view.msaa > 1)
    p.feature("multisampling", std::to_string(p.in.view.msaa) + " samples a pixel were asked for");
  else
    p.leave_out("multisampling", "one sample a pixel was asked for", "--msaa");
  decide_octree(p);
}

void plan_layers(const Planning& p, const Registry& registry) {
  std::vector<ShadingPlan>& layers = p.plan->layers;
  for (ShadingPlan& layer : layers) {
    const Technique& mode = registry.find_mode(layer.mode);
    decide_visibility(p, mode, &layer);
    decide_shadow_rays(p, mode, &layer);
    decide_indirect(p, mode, &layer);
    decide_lights(p, mode, &layer);
    decide_own_bake(p, mode, &layer);
  }
  decide_reflections(p, false);
  p.plan->glass = p.in.facts.has_glass || (!p.plan->reflections.empty() && p.in.view.mirrors);
  decide_glossy(p, registry.find_mode(layers[0].mode));
  decide_octree(p);
  note_fits(p);
  note_parts(p);
  decide_details(p);
  add_surface_passes(p);
  bool averages_points = true;
  for (std::size_t k = 0; k < layers.size(); ++k) {
    const Technique& mode = registry.find_mode(layers[k].mode);
    averages_points = averages_points && mode.can.averages_points;
    const std::size_t first = p.plan->passes.size();
    mode.add_passes(p.in, &layers[k], p.plan);
    if (layers[k].indirect == "baked")
      p.add({"indirect",
             "what sees no sky is lit by other surfaces: baked per vertex, all bounces",
             {"surfaces"},
             {"indirect light"}});
    add_shadow_ray_passes(p, layers[k]);
    for (std::size_t i = first; i < p.plan->passes.size(); ++i) p.plan->passes[i].layer = static_cast<int>(k);
  }
  if (p.plan->glossy) {
    const int in_view = p.in.view.glossy_in_view;
    p.add({"glossy",
           (in_view >= 0 ? std::to_string(in_view) + " glossy" : std::string("glossy")) +
               " opaque surfaces may be seen: what they mirror of others is traced, " + "reflections.resolution " +
               p.in.settings.get_string("reflections.resolution"),
           {"surfaces"},
           {"glossy light"}});
  }
  add_picture_passes(p, averages_points);
}

FramePlan decide(const PlanInput& input, const std::string& mode_name, const Registry& registry) {
  const Technique& mode = registry.find_mode(mode_name);
  const Technique* reflector = registry.find_reflector(input.view.reflections);
  FramePlan plan;
  plan.layers = make_layers(mode_name, input.view, input.facts, registry);
  std::vector<const Technique*> used{reflector};
  for (const ShadingPlan& layer : plan.layers) used.push_back(&registry.find_mode(layer.mode));
  check_request(input.facts, input.settings, input.view, used, registry);
  const Planning planning{input, reflector, &plan};
  if (mode.can.traces_picture)
    plan_traced_picture(planning, mode);
  else
    plan_layers(planning, registry);
  const auto samples = [&](const ShadingPlan& layer) { return registry.find_mode(layer.mode).can.samples; };
  if (std::none_of(plan.layers.begin(), plan.layers.end(), samples))
    planning.leave_out("sampling", "lookups take no samples: --samples has no effect", kMode);
  note_absent_features(planning);
  // A word is either in or out.
  std::erase_if(plan.left_out, [&](const LeftOut& left_out) {
    const auto has = [&](const auto& entry) { return entry.name == left_out.what; };
    return std::any_of(plan.features.begin(), plan.features.end(), has) ||
           std::any_of(plan.passes.begin(), plan.passes.end(), has);
  });
  return plan;
}

/// What is brought up to date for a frame that has all it wants: Renderer::Impl::prepare (render/renderer.cpp) carries
/// each step out.
std::vector<PlannedPass> preparations_for(const FramePlan& wanted, const SceneFacts& facts, const Registry& registry) {
  std::vector<PlannedPass> steps;
  const auto any_layer = [&](const auto& has) { return std::any_of(wanted.layers.begin(), wanted.layers.end(), has); };
  if (registry.find_mode(wanted.layers[0].mode).can.traces_picture) return steps;
  if (any_layer([](const ShadingPlan& l) { return l.lights; }))
    steps.push_back({"list_lights", "lights and emissive surfaces are chosen from lists", {}, {"light lists"}});
  const bool indirect = any_layer([](const ShadingPlan& l) { return l.indirect == "baked"; });
  if (indirect || wanted.any_layer_is_shadowed_by("baked"))
    steps.push_back({"bake_visibility", "shadows of the sky by vertex", {}, {"visibility"}});
  const bool partly_open = !wanted.reflections.empty() && (facts.has_glass || facts.has_mask);
  if (partly_open || any_layer([](const ShadingPlan& l) { return l.shadow_rays; }))
    steps.push_back({"build_shadow_rays", "what rays on the processor may meet", {}, {"shadow_rays"}});
  if (indirect) steps.push_back({"bake_indirect", "indirect light by vertex", {"visibility"}, {"indirect"}});
  for (const ShadingPlan& layer : wanted.layers)
    if (!layer.own_bake.empty())
      steps.push_back({"bake_" + layer.own_bake, "mode " + layer.mode + " draws with it", {}, {layer.own_bake}});
  if (wanted.octree) steps.push_back({"build_octree", "rays go through it", {}, {words::kOctree}});
  if (wanted.cell_brdfs)
    steps.push_back({"bake_cells", "BRDFs of the octree's cells", {words::kOctree}, {"cell_brdfs"}});
  return steps;
}

}  // namespace

std::map<std::string, BakeStatus> FrameStatus::bakes() const {
  std::map<std::string, BakeStatus> wanted = own_bakes;
  wanted.insert({{"visibility", visibility},
                 {"indirect", indirect},
                 {words::kOctree, octree},
                 {"cell_brdfs", cell_brdfs},
                 {"shadow_rays", shadow_rays}});
  std::erase_if(wanted, [](const auto& entry) { return !entry.second.wanted; });
  return wanted;
}

bool FramePlan::any_layer_is_shadowed_by(const std::string& visibility) const {
  return std::any_of(layers.begin(), layers.end(), [&](const ShadingPlan& l) { return l.visibility == visibility; });
}

bool FramePlan::prepares(const std::string& name) const {
  return std::any_of(preparations.begin(), preparations.end(),
                     [&](const PlannedPass& step) { return step.name == name; });
}

std::string FramePlan::pass_title(const std::string& name, int layer) const {
  if (layers.size() < 2 || layer < 0) return name;
  return name + " (" + layers[static_cast<std::size_t>(layer)].mode + ")";
}

FramePlan plan(const SceneFacts& facts, const std::string& mode, const Settings& settings, const ViewInfo& view,
               const FrameStatus& status, const Registry& registry) {
  const FrameStatus all_ready;
  FramePlan plan = decide({facts, settings, view, status}, mode, registry);
  plan.preparations = preparations_for(decide({facts, settings, view, all_ready}, mode, registry), facts, registry);
  return plan;
}

}  // namespace maquette
