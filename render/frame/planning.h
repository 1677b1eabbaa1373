#pragma once

#include <algorithm>
#include <string>
#include <utility>

#include "render/frame/plan.h"
#include "render/technique/technique.h"

namespace maquette {

// LeftOut::decided_by, where it is no setting or option.
inline constexpr const char *kScene = "scene", *kView = "view", *kMode = "mode", *kStatus = "status";

/// What the decisions below share.
struct Planning {
  const PlanInput& in;
  const Technique* reflector;  ///< that was asked for; null: off
  FramePlan* plan;

  void add(PlannedPass pass) const { plan->passes.push_back(std::move(pass)); }
  void feature(const std::string& name, const std::string& reason) const {
    const bool known = std::any_of(plan->features.begin(), plan->features.end(), [&](const Feature& feature) {
      return feature.name == name && feature.reason == reason;
    });
    if (!known) plan->features.push_back({name, reason});
  }
  void leave_out(const std::string& what, const std::string& why, const std::string& decided_by) const {
    const bool known = std::any_of(plan->left_out.begin(), plan->left_out.end(),
                                   [&](const LeftOut& left_out) { return left_out.what == what; });
    if (!known) plan->left_out.push_back({what, why, decided_by});
  }
};

/// In whole percent, rounded down: 100 % means done.
std::string percent_done(double progress);
std::string not_ready(const std::string& what, const BakeStatus& bake);

// What a layer's light is (render/frame/planned_light.cpp).
/// Whether the settings want baked shadows, ready or not.
bool wants_baked(const Planning& p, const Technique& mode);
void decide_visibility(const Planning& p, const Technique& mode, ShadingPlan* shading);
/// Rays to what shines brightly, from every visible point.
void decide_shadow_rays(const Planning& p, const Technique& mode, ShadingPlan* shading);
/// Indirect light fills what the sky's shadows leave black; without shadows there is nothing to fill.
void decide_indirect(const Planning& p, const Technique& mode, ShadingPlan* shading);
void decide_lights(const Planning& p, const Technique& mode, ShadingPlan* shading);
/// The bake that the technique itself declares.
void decide_own_bake(const Planning& p, const Technique& mode, ShadingPlan* shading);
void add_shadow_ray_passes(const Planning& p, const ShadingPlan& shading);

}  // namespace maquette
