#include <cmath>
#include <cstdio>

#include "render/frame/planning.h"

namespace maquette {

std::string percent_done(double progress) {
  char text[16];
  std::snprintf(text, sizeof text, "%.0f %%", std::floor(100.0 * progress));
  return text;
}

std::string not_ready(const std::string& what, const BakeStatus& bake) {
  return what + " not " + (what == "it is" ? "built" : "ready") + " yet: " + percent_done(bake.progress);
}

namespace {

/// Surfaces that hide less of the sky from each other have next to no indirect light either.
constexpr double kLeastHiddenShare = 0.005;

/// Why maps and indirect light are wanted or left out where the scene decides.
std::string hidden_reason(const Planning& p) {
  char text[80];
  const double share = 100.0 * p.in.view.hidden_share.value_or(0.0);
  std::snprintf(text, sizeof text, "surfaces hide %.2g %% of the sky from each other", share);
  return text;
}

/// Why a pass has nothing to do for a mode that cannot take what it makes.
std::string lacks(const Technique& mode, const std::string& nothing, const std::string& what) {
  return mode.own_bake ? what + " that mode " + mode.name + " shows are in what it bakes"
                       : "mode " + mode.name + " knows " + nothing;
}

}  // namespace

bool wants_baked(const Planning& p, const Technique& mode) {
  const std::string& asked = p.in.settings.get_string("shading.visibility");
  const bool by_scene = asked == "auto" || asked == "rays";
  const bool pays = p.in.facts.enclosed || p.in.view.hidden_share.value_or(0.0) >= kLeastHiddenShare;
  return mode.can.shadows && (asked == "baked" || (by_scene && pays));
}

/// Without indirect light a cabin is black where the sky is shadowed: both come together.
bool awaits_indirect(const Planning& p, const Technique& mode) {
  return mode.can.indirect && p.in.settings.get_string("shading.indirect") != "none" && wants_baked(p, mode) &&
         !p.in.status.indirect.ready;
}

void decide_shadow_rays(const Planning& p, const Technique& mode, ShadingPlan* shading) {
  if (mode.can.traces_picture) return;
  const auto leave_out = [&](const std::string& why, const std::string& by) { p.leave_out("shadow_rays", why, by); };
  const std::string& asked = p.in.settings.get_string("shading.visibility");
  if (!mode.can.shadows) return leave_out(lacks(mode, "no shadows", "shadows"), kMode);
  if (asked != "auto" && asked != "rays") return leave_out("shading.visibility is " + asked, "shading.visibility");
  if (!p.in.status.has_geometry) return leave_out("nothing is there to occlude", kScene);
  if (!p.in.status.shadow_rays.ready) return leave_out("what they meet is not built yet", kStatus);
  shading->shadow_rays = true;
  shading->sky_rays = (p.in.status.accumulated > 0 || p.in.status.single) && !awaits_indirect(p, mode);
  shading->sun_apart = p.in.status.has_sun;
}

void decide_visibility(const Planning& p, const Technique& mode, ShadingPlan* shading) {
  if (mode.can.traces_picture) return;  // its own rays; add_passes says so
  const std::string& asked = p.in.settings.get_string("shading.visibility");
  if (!mode.can.shadows) return p.leave_out("visibility", lacks(mode, "none", "shadows"), kMode);
  if (asked == "traced") {
    if (!p.in.status.octree.ready) return p.leave_out("visibility", "its octree is not built yet", kStatus);
    shading->visibility = "traced";
    return p.feature("visibility", "shading.visibility is traced: the samples' rays go through the octree");
  }
  if (wants_baked(p, mode)) {
    if (!p.in.status.has_geometry) return p.leave_out("visibility", "nothing is there to occlude", kScene);
    if (!p.in.status.visibility.ready)
      return p.leave_out("visibility", not_ready("its bake is", p.in.status.visibility), kStatus);
    if (awaits_indirect(p, mode))
      return p.leave_out("visibility", "it comes with indirect light, without which shadows would be black", kStatus);
    shading->visibility = "baked";
    return p.feature("visibility", asked == "baked" ? "shading.visibility is baked"
                                   : p.in.facts.enclosed
                                       ? "the scene closes the eye in: without it light comes through the roof"
                                       : hidden_reason(p));
  }
  if (asked == "none") return p.leave_out("visibility", "shading.visibility is none", "shading.visibility");
  if (!p.in.view.hidden_share) return p.leave_out("visibility", "what hides the sky is not counted yet", kStatus);
  p.leave_out("visibility", hidden_reason(p), kScene);
}

void decide_indirect(const Planning& p, const Technique& mode, ShadingPlan* shading) {
  if (mode.can.traces_picture) return;
  const auto leave_out = [&](const std::string& why, const std::string& by) { p.leave_out("indirect", why, by); };
  if (!mode.can.indirect) return leave_out(lacks(mode, "none", "light between surfaces"), kMode);
  if (p.in.settings.get_string("shading.indirect") == "none")
    return leave_out("shading.indirect is none", "shading.indirect");
  const bool traced = p.in.settings.get_string("shading.visibility") == "traced";
  if (!traced && !wants_baked(p, mode)) {
    if (p.in.settings.get_string("shading.visibility") == "none")
      return leave_out("nothing shadows the sky, so there is nothing that it would fill", "shading.visibility");
    return leave_out("it goes with visibility maps, which are left out", p.in.view.hidden_share ? kScene : kStatus);
  }
  if (!p.in.status.visibility.ready) return leave_out("it waits for the bake of visibility", kStatus);
  if (!p.in.status.indirect.ready) return leave_out(not_ready("its bake is", p.in.status.indirect), kStatus);
  if (shading->visibility == "none") return leave_out("it waits for what shadows the sky", kStatus);
  shading->indirect = "baked";
}

void decide_lights(const Planning& p, const Technique& mode, ShadingPlan* shading) {
  const bool shines = p.in.facts.has_punctual_lights || p.in.facts.has_emissive_meshes;
  if (!shines) return p.leave_out("lights", "the scene has no lights and nothing that glows", kScene);
  if (mode.own_bake && mode.own_bake->has_lights)
    return p.leave_out("lights", "their light is in what is baked", mode.own_bake->name);
  if (!mode.can.lights) return p.leave_out("lights", "mode " + mode.name + " knows the environment only", kMode);
  if (!p.in.status.lights_count) return p.leave_out("lights", "what glows is too dim to count", kScene);
  shading->lights = true;
  p.feature("lights",
            p.in.facts.has_emissive_meshes ? "emissive surfaces light the scene" : "the scene has lights of its own");
}

void decide_own_bake(const Planning& p, const Technique& mode, ShadingPlan* shading) {
  if (!mode.own_bake) return;
  const OwnBake& own = *mode.own_bake;
  const auto status = p.in.status.own_bakes.find(own.name);
  if (status != p.in.status.own_bakes.end() && !status->second.ready)
    return p.leave_out(own.name, not_ready("its bake is", status->second), kStatus);
  shading->own_bake = own.name;
  p.feature(own.name, own.reason);
}

void add_shadow_ray_passes(const Planning& p, const ShadingPlan& shading) {
  if (!shading.shadow_rays) return;
  const std::string sun = shading.sun_apart ? "the sun and " : "", sky = shading.sky_rays ? ", and to the sky" : "";
  p.add({"draw_rays",
         "from each point to " + sun + "lamps" + sky + ", with what they bring",
         {"surfaces"},
         {"shadow rays"}});
  p.add({"trace_rays", "on the processor: what lies between", {"shadow rays"}, {"shadow light"}});
}

}  // namespace maquette
