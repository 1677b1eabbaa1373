#include "viewer/report/sweep.h"

#include <algorithm>

#include "scenes/error.h"
#include "viewer/session.h"

namespace maquette::report {

std::vector<SweptCamera> swept_cameras(const Scene& scene, const SceneOptions& options) {
  std::vector<SweptCamera> cameras;
  if (options.eye || !options.camera.empty()) {
    cameras.push_back({options.camera.empty() ? "eye" : options.camera, camera_of_options(scene, options)});
    return cameras;
  }
  SceneOptions one = options;
  for (const std::string& name : camera_names(scene)) {
    const bool known =
        std::any_of(cameras.begin(), cameras.end(), [&](const SweptCamera& c) { return c.name == name; });
    if (known || name.empty()) continue;
    one.camera = name;
    cameras.push_back({name, camera_of_options(scene, one)});
  }
  if (cameras.empty()) cameras.push_back({"overview", camera_of_options(scene, options)});
  return cameras;
}

namespace {

/// Of a mode whose shadows are compared: the few points that it shades make rays through the octree affordable.
void append_visibilities(const SweptTechnique& as_asked, const std::string& visibility, bool sweeps_visibility,
                         std::vector<SweptTechnique>* swept) {
  if (!sweeps_visibility || visibility == "none") return;
  for (const char* other : {"none", "baked", "traced", "rays"}) {
    if (other == visibility) continue;
    SweptTechnique technique = as_asked;
    technique.name += std::string("-") + other;
    technique.help += ", with shading.visibility " + std::string(other);
    technique.visibility = other;
    swept->push_back(std::move(technique));
  }
}

/// A bake takes minutes, which are no part of a frame: it is measured where it was made before and is named.
std::optional<std::string> why_not_baked(const OwnBake& bake, const Technique& info, const Settings& settings) {
  const std::string setting = bake.name + ".bake";
  const auto given = [&](const std::string& name) {
    const bool known = std::ranges::any_of(info.settings, [&](const SettingDeclaration& s) { return s.name == name; });
    return known && !settings.get_string(name).empty();
  };
  if (given(bake.name + ".parts")) return "only parts of the scene would be drawn (" + bake.name + ".parts)";
  if (given(setting)) return std::nullopt;
  return "it draws with a bake of minutes; make it first (maquette bake " + bake.name +
         " SCENE -o DIR) and name it: --set " + setting + "=DIR";
}

}  // namespace

std::vector<SweptTechnique> swept_techniques(const SceneFacts& facts, const Settings& settings, std::size_t reflectors,
                                             const Registry& registry) {
  std::vector<SweptTechnique> swept;
  for (const TechniqueKind kind : {TechniqueKind::mode, TechniqueKind::reflector}) {
    for (const Technique& info : registry.techniques) {
      if (info.kind != kind) continue;
      SweptTechnique technique{info.name, info.help, kind, info.quality_steps, {}, info.name, {}};
      if (kind == TechniqueKind::reflector) technique.mode = reflection_mode(registry);
      std::string visibility = "none";
      if (technique.steps.empty()) technique.steps.emplace_back();
      ViewInfo view;
      if (kind == TechniqueKind::reflector) view.reflections = info.name;
      if (reflectors > 0) view.reflectors = static_cast<int>(reflectors);
      try {
        const FramePlan frame = plan(facts, technique.mode, settings, view, {}, registry);
        visibility = frame.shading().visibility;
        if (visibility == "baked" && frame.shading().shadow_rays) visibility = "rays";
        const auto why = std::find_if(frame.left_out.begin(), frame.left_out.end(),
                                      [](const LeftOut& l) { return l.what == "reflections"; });
        if (kind == TechniqueKind::reflector && why != frame.left_out.end()) technique.refused = why->why;
        if (info.own_bake) technique.refused = why_not_baked(*info.own_bake, info, settings);
      } catch (const Error& error) {
        technique.refused = error.what();
      }
      swept.push_back(technique);
      append_visibilities(technique, visibility, info.can.sweeps_visibility, &swept);
    }
  }
  return swept;
}

const std::string& reflection_mode(const Registry& registry) {
  const Technique* mode = registry.first_that(TechniqueKind::mode, &Capabilities::judges_reflections);
  return mode ? mode->name : registry.default_mode;
}

const std::string& reflection_reference(const Registry& registry) {
  static const std::string kNone;
  const Technique* exact = registry.first_that(TechniqueKind::reflector, &Capabilities::is_exact);
  return exact ? exact->name : kNone;
}

std::string quality_label(const QualityStep& step) {
  std::string label = step.samples > 0 ? std::to_string(step.samples) + " samples" : "";
  for (const auto& [name, value] : step.settings) label += (label.empty() ? "" : ", ") + name + " " + to_text(value);
  return label.empty() ? "default" : label;
}

FrameRequest request_of(FrameRequest request, const SweptTechnique& technique, const QualityStep& step, Scope scope,
                        const Registry& registry) {
  const bool reflector = technique.kind == TechniqueKind::reflector;
  request.mode = technique.mode;
  request.reflections = reflector ? technique.name : kNoReflections;
  request.samples = step.samples;
  for (const auto& [name, value] : step.settings) request.settings.set(name, value);
  if (!technique.visibility.empty()) request.settings.set("shading.visibility", technique.visibility);
  if (scope != Scope::estimator) return request;
  for (const Technique& info : registry.techniques)
    if (info.kind == TechniqueKind::shared || info.name == technique.mode)
      for (const auto& [name, value] : info.restricted_settings) request.settings.set(name, value);
  return request;
}

}  // namespace maquette::report
