#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/technique/settings.h"
#include "scenes/environment.h"
#include "scenes/scene.h"

namespace maquette {

/// What `maquette bake` is asked for.
struct BakeRequest {
  const Scene& scene;
  int variant = -1;
  const Settings& settings;
  std::map<std::string, std::string> materials;  ///< replaced: name to source
  std::string folder;                            ///< empty: where a render of these settings looks
  /// Loads the environment, for bakes of light; called only by them. Null: there is none.
  std::function<std::shared_ptr<const Environment>()> environment = {};
  float env_rotation_rad = 0.0f, env_scale = 1.0f;
  std::vector<std::string> given = {};  ///< settings that the user has set, defaults too
};

struct BakeControl {
  const std::atomic<bool>& cancel;
  std::function<void(const std::string& what, double share)> progress;  ///< in [0, 1]
  std::function<void(const std::string& line)> report;                  ///< what was made, for the user
};

/// Figures of what a bake's files hold, for `maquette inspect`, in order. Names with dots are nested.
using BakeFigures = std::vector<std::pair<std::string, double>>;

/// A bake that can be made by command, before a render needs it.
struct BakeCommand {
  std::string name;
  std::string help;
  /// Throws Error, also when it was cancelled; what is done by then is kept, and the same request resumes it.
  std::function<void(const BakeRequest&, const BakeControl&)> run;
  /// Of a folder of this bake; nothing for what is none of its own, or not whole. `scene`: that it was baked of, or
  /// null. Null: has none. Throws Error.
  std::function<std::optional<BakeFigures>(const std::string& folder, const Scene* scene)> inspect = {};
  bool of_light = false;  ///< reads the environment
};

}  // namespace maquette
