#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/plan.h"
#include "render/settings.h"

namespace maquette {

enum class TechniqueKind {
  shared,     ///< settings that several modes read
  mode,       ///< a shading mode of the opaque surfaces (`--mode`)
  reflector,  ///< how mirrors and glass are drawn (`--reflections`)
};

/// One point of the report's sweep: what to change to trade time for error.
struct QualityStep {
  int samples = 0;  ///< as `--samples`; 0: the mode's default
  std::vector<std::pair<std::string, SettingValue>> settings = {};
};

/// What one technique declares of itself, in its own folder (render/NAME/technique.cpp). The renderer finds it by name.
struct TechniqueInfo {
  std::string name;
  TechniqueKind kind = TechniqueKind::mode;
  std::string help;  ///< one line
  std::vector<SettingDeclaration> settings;
  int default_samples = 0;  ///< modes: shading samples a pixel when `--samples` is not given
  /// Of the report, from fast to good. Empty: its only quality is the default.
  std::vector<QualityStep> quality_steps = {};
  /// Settings that restrict it to unshadowed direct light, what `reference.transport=direct` computes: the report's
  /// estimator error is measured with them. Those of shared techniques hold for every mode.
  std::vector<std::pair<std::string, SettingValue>> restricted_settings = {};
  /// Why it cannot draw what is asked, or nothing. May be empty: it always can.
  std::function<std::optional<std::string>(const SceneFacts&, const Settings&)> check;
  /// Modes: adds the passes between `gbuffer` and `compose`, and what it leaves out, each with its reason.
  std::function<void(const SceneFacts&, const Settings&, const ViewInfo&, FramePlan*)> add_passes;
};

/// Every technique, in the order of the manual. Adding one is one line in registry.cpp.
const std::vector<TechniqueInfo>& techniques();

/// The mode or reflector technique of that name. Throws UsageError for an unknown name ("did you mean ...") and Error
/// for one that arrives with a later version.
const TechniqueInfo& find_mode(const std::string& name);
/// Reflector techniques; `off` is none of them and returns nullptr.
const TechniqueInfo* find_reflector_technique(const std::string& name);
std::vector<std::string> technique_names(TechniqueKind kind);

/// Names that the contract knows and this version does not have yet.
struct LaterName {
  std::string name;
  std::string help;
};
const std::vector<LaterName>& later_modes();
const std::vector<LaterName>& later_settings();

}  // namespace maquette
