#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/bake/bake_command.h"
#include "render/frame/plan.h"
#include "render/technique/debug_view.h"
#include "render/technique/settings.h"
#include "render/technique/word.h"

namespace maquette {

struct ShaderVariant;
class SceneBake;
class ShadingMode;
class PictureMode;
class ReflectorTechnique;

enum class TechniqueKind {
  shared,     ///< settings that several techniques read
  mode,       ///< a shading mode of the opaque surfaces (`--mode`)
  reflector,  ///< how mirrors and glass are drawn (`--reflections`)
};

/// What a technique can do. Core, panels and commands ask these, never names.
struct Capabilities {
  // Of modes:
  bool samples = false;             ///< `--samples` counts; noise falls with it
  bool shadows = false;             ///< knows `shading.visibility`
  bool indirect = false;            ///< knows `shading.indirect`
  bool lights = false;              ///< the scene's own lights shine
  bool averages_points = false;     ///< its points hold the mean over frames; the others' pictures are averaged
  bool traces_picture = false;      ///< draws whole pictures by rays of its own: no part of a frame
  bool sweeps_visibility = false;   ///< the report compares its kinds of shadows
  bool judges_reflections = false;  ///< noiseless: the report compares reflector techniques in it
  // Of reflectors:
  bool needs_octree = false;      ///< rays go through it
  bool needs_eye = false;         ///< projects from one point: no orthographic cameras
  bool needs_patches = false;     ///< curved meshes get patches fitted to them
  bool keeps_hits = false;        ///< hits hold while camera and surfaces stay
  bool hits_cells = false;        ///< rays hit cells of the octree, which the default mode shades
  bool skips_rays = false;        ///< single rays can be left out ...
  bool skips_cheap_rays = false;  ///< ... and that pays where shading takes no rays through the octree, too
  bool is_exact = false;          ///< the reference of the others
};

/// One point of the report's sweep: what to change to trade time for error.
struct QualityStep {
  int samples = 0;  ///< as `--samples`; 0: the mode's default
  std::vector<std::pair<std::string, SettingValue>> settings = {};
};

/// A bake that a mode draws with. While it is not ready, `ShadingPlan::own_bake` is empty, and the mode draws without.
struct OwnBake {
  std::string name;    ///< word of the vocabulary, of kind feature; its preparation is the word "bake_" + name
  std::string reason;  ///< what the mode draws with it
  std::function<std::unique_ptr<SceneBake>()> make = {};  ///< called when a plan first wants it
  bool has_lights = false;                                ///< what the scene's own lights bring is in it
  std::vector<std::string> settings = {};                 ///< names of those that decide what is baked
};

/// What a mode's plan function decides from.
struct PlanInput {
  const SceneFacts& facts;
  const Settings& settings;
  const ViewInfo& view;
  const FrameStatus& status;
};

/// What one technique declares of itself, in its own folder. A value: the registry lists it, and everything else finds
/// it there.
struct Technique {
  std::string name;
  TechniqueKind kind = TechniqueKind::mode;
  std::string help;  ///< one line
  Capabilities can = {};
  std::vector<SettingDeclaration> settings = {};
  std::string samples_setting = {};  ///< modes that sample: what `--samples` stands for
  /// Of the report, from fast to good. Empty: its only quality is the default.
  std::vector<QualityStep> quality_steps = {};
  /// Settings that restrict it to unshadowed direct light, what `reference.transport=direct` computes: the report's
  /// estimator error is measured with them. Those of shared techniques hold for every mode.
  std::vector<std::pair<std::string, SettingValue>> restricted_settings = {};
  /// Shared settings: whether they have an effect on a picture of these techniques. Null: always.
  std::function<bool(const Technique& mode, const Technique* reflector, const Settings&)> has_effect = {};
  /// Why it cannot draw what is asked, or nothing. Null: it always can.
  std::function<std::optional<std::string>(const SceneFacts&, const Settings&)> check = {};
  /// Adds its passes, of a mode those between `gbuffer` and `compose` of the layer `shading`, and what it leaves out.
  std::function<void(const PlanInput&, ShadingPlan* shading, FramePlan*)> add_passes = {};
  /// What carries the passes out; made when it is first drawn with. Of kind mode, without `traces_picture`.
  std::function<std::unique_ptr<ShadingMode>()> make_mode = {};
  /// The same of a mode with `traces_picture`.
  std::function<std::unique_ptr<PictureMode>()> make_picture_mode = {};
  /// Of kind mode: started, taken over, awaited, listed and counted by SceneBakes.
  std::optional<OwnBake> own_bake = {};
  /// Of kind reflector.
  std::function<std::unique_ptr<ReflectorTechnique>()> make_reflector = {};
  /// The same for the rays of glossy opaque surfaces (render/glossy). Null: only panes and mirrors reflect.
  std::function<std::unique_ptr<ReflectorTechnique>()> make_glossy = {};
  /// Every shader variant that it may ask for, for the test that compiles them all.
  std::function<std::vector<ShaderVariant>()> shader_variants = {};
  /// Debug views (`--view`) that it adds: of modes. Those of mirrored rays are in Reflections::views().
  std::vector<DebugViewInfo> views = {};
  /// Words that it adds to plans and stats.
  std::vector<Word> words = {};
  /// What `maquette bake` can make for it.
  std::vector<BakeCommand> bakes = {};
};

}  // namespace maquette
