#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/frame/pass.h"
#include "render/frame/request.h"
#include "render/frame/status.h"
#include "render/scene_state/facts.h"
#include "render/technique/settings.h"

namespace maquette {

struct Registry;
const Registry& builtin_registry();

/// What the plan needs to know of a view.
struct ViewInfo {
  int width = 640;
  int height = 360;
  int msaa = 1;
  std::string reflections = kNoReflections;
  int reflectors = -1;          ///< named or marked in the scene; -1: as many as the facts count
  int reflectors_in_view = -1;  ///< of them; -1: not known, all
  bool orthographic = false;
  bool mirrors = false;  ///< some reflector is opaque
  /// How much of the sky the parts' surfaces hide from each other (render/shadow_rays); nothing: not known yet.
  std::optional<double> hidden_share = {};
  int glossy_in_view = -1;  ///< opaque surfaces that `reflections.glossy` or a name lets mirror; -1: by the facts
  std::vector<PartMode> part_modes = {};  ///< nodes that have another shading mode than the rest
};

struct LeftOut {
  std::string what;  ///< a word of docs/vocabulary.md
  std::string why;
  /// What decided it, as data: the name of a setting or option, or `scene`, `view`, `mode`, `status`.
  std::string decided_by = {};
};

/// Something that the frame has or does besides its passes.
struct Feature {
  std::string name;  ///< a word of docs/vocabulary.md
  std::string reason;
};

/// How one shading mode shades its share of the frame.
struct ShadingPlan {
  std::string mode;
  std::vector<std::string> nodes;   ///< whose parts it shades, with what is below them; empty: all others
  std::string visibility = "none";  ///< none, baked or traced, after `auto` was decided
  std::string indirect = "none";    ///< none or baked
  std::string own_bake;             ///< the technique's, once it is ready; else empty
  bool texture_bandwidth = false;
  bool shadow_rays = false;               ///< what shines brightly is shadowed by rays, point by point
  bool sky_rays = false;                  ///< at rest also to the rest of the sky
  bool sun_apart = false;                 ///< by them alone comes the sun's light: samples leave it out
  bool lights = false;                    ///< punctual lights or emissive meshes are sampled
  bool sheen = false, clearcoat = false;  ///< lobes that analytic materials may have
};

/// The passes and features for this scene, camera, settings and status. A plain value, made without OpenGL; nobody
/// changes it afterwards.
struct FramePlan {
  std::vector<ShadingPlan> layers = std::vector<ShadingPlan>(1);  ///< first the default mode's
  bool glass = false;
  std::string reflections;  ///< reflector technique, or empty
  bool glossy = false;      ///< opaque surfaces mirror too
  bool octree = false, cell_brdfs = false;
  bool details = false;  ///< the second part of the G-buffer is filled
  /// What is brought up to date before: lists, bakes. Of all that is wanted, whether it is ready or not.
  std::vector<PlannedPass> preparations;
  std::vector<PlannedPass> passes;  ///< in the order in which they are carried out
  std::vector<Feature> features;
  std::vector<LeftOut> left_out;

  const ShadingPlan& shading() const { return layers.front(); }
  bool any_layer_is_shadowed_by(const std::string& visibility) const;
  /// Whether the preparation of this name is one of its.
  bool prepares(const std::string& name) const;
  /// How a pass is called where times and reasons are listed: with its mode, where several layers have one.
  std::string pass_title(const std::string& name, int layer) const;
};

/// Decides what a frame does. Throws Error when the mode cannot do what was asked (never falls back to another), and
/// UsageError for unknown names.
FramePlan plan(const SceneFacts& facts, const std::string& mode, const Settings& settings, const ViewInfo& view,
               const FrameStatus& status = {}, const Registry& registry = builtin_registry());

}  // namespace maquette
