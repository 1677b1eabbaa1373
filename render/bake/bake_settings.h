#pragma once

#include <string>
#include <vector>

#include "render/technique/registry.h"
#include "render/technique/settings.h"

namespace maquette {

/// What was set otherwise than declared when a bake was begun, kept in its folder as `settings.txt`, a line NAME=VALUE
/// each, so that to name the folder is enough. `names`: OwnBake::settings. Writes only where nothing is baked yet.
/// Throws Error.
void begin_bake_settings(const std::string& folder, const Settings& settings, const std::vector<std::string>& names);

/// With what the folder of a bake says of those of `names` that are as declared; others stay, and where they contradict
/// the bake its own check says so. A folder without the file changes nothing. Throws UsageError where the folder
/// contradicts one of `given`, which the user has set, also as declared.
Settings with_settings_of(const std::string& folder, Settings settings, const std::vector<std::string>& names,
                          const std::vector<std::string>& given = {});

/// The same for every folder that the settings themselves name for a mode's own bake (`slf.bake`), or that lies in it
/// for this scene.
Settings with_settings_of_bakes(const Registry& registry, Settings settings, const std::string& scene);

/// Throws UsageError where one of `given`, which the user has set, is not what a folder of with_settings_of_bakes says
/// of it.
void check_given_settings(const Registry& registry, const Settings& settings, const std::vector<std::string>& given,
                          const std::string& scene);

}  // namespace maquette
