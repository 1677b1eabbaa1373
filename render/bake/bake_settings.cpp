#include "render/bake/bake_settings.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <span>
#include <sstream>

#include "render/bake/bake_attributes.h"
#include "scenes/error.h"
#include "scenes/files.h"

namespace maquette {

namespace {

std::string settings_file(const std::string& folder) {
  return (std::filesystem::path(folder) / "settings.txt").string();
}

/// {name: value} of those of `names` that a folder says.
std::map<std::string, std::string> settings_of_folder(const std::string& folder,
                                                      const std::vector<std::string>& names) {
  constexpr std::size_t kLargest = 1u << 16u;
  const std::string file = settings_file(folder);
  std::map<std::string, std::string> found;
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return found;
  const std::vector<std::byte> bytes = read_file(file, kLargest);
  std::istringstream lines(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  for (std::string line; std::getline(lines, line);) {
    const std::string name = line.substr(0, line.find('='));
    if (std::ranges::find(names, name) != names.end())
      found[name] = line.substr(std::min(name.size() + 1, line.size()));
  }
  return found;
}

/// Throws UsageError where a folder says of one of `given` otherwise.
void check_given(const std::string& folder, const Settings& settings, const std::vector<std::string>& names,
                 const std::vector<std::string>& given) {
  if (given.empty()) return;
  std::map<std::string, std::string> said;
  try {
    said = settings_of_folder(folder, names);
  } catch (const Error&) {  // damaged: the bake's own check says what does not fit
  }
  for (const std::string& name : given) {
    const auto found = said.find(name);
    if (found == said.end()) continue;
    Settings of_folder;
    try {
      of_folder.set_from_text(name, found->second);
    } catch (const Error&) {
      continue;
    }
    if (of_folder.get(name) != settings.get(name))
      throw UsageError("--set " + name + "=" + to_text(settings.get(name)),
                       "the bake in " + folder + " was made with " + found->second,
                       "leave it away, or name another folder");
  }
}

/// The folders of modes' own bakes that settings name, and those of a scene in them: calls `visit` with the folder and
/// the bake.
template <typename Visit>
void for_named_bakes(const Registry& registry, const Settings& settings, const std::string& scene, const Visit& visit) {
  for (const std::string& mode : registry.names(TechniqueKind::mode)) {
    const auto& own = registry.find_mode(mode).own_bake;
    if (!own || !find_setting(own->name + ".bake")) continue;
    const std::string folder = settings.get_string(own->name + ".bake");
    if (folder.empty()) continue;
    visit(folder, *own);
    visit((std::filesystem::path(folder) / (bake_name_of_scene(scene) + "-" + own->name)).string(), *own);
  }
}

}  // namespace

void begin_bake_settings(const std::string& folder, const Settings& settings, const std::vector<std::string>& names) {
  std::string text;
  for (const auto& [name, value] : settings.changed())
    if (std::ranges::find(names, name) != names.end()) text += name + "=" + to_text(value) + "\n";
  std::error_code ignored;
  std::filesystem::create_directories(folder, ignored);
  if (!std::filesystem::is_empty(folder, ignored)) return;
  write_file_atomically(settings_file(folder), std::as_bytes(std::span(text)));
}

Settings with_settings_of(const std::string& folder, Settings settings, const std::vector<std::string>& names,
                          const std::vector<std::string>& given) {
  check_given(folder, settings, names, given);
  try {
    for (const auto& [name, value] : settings_of_folder(folder, names))
      if (!settings.changed().contains(name)) settings.set_from_text(name, value);
  } catch (const Error&) {  // damaged, as above
  }
  return settings;
}

Settings with_settings_of_bakes(const Registry& registry, Settings settings, const std::string& scene) {
  for_named_bakes(registry, Settings(settings), scene, [&](const std::string& folder, const OwnBake& own) {
    settings = with_settings_of(folder, std::move(settings), own.settings);
  });
  return settings;
}

void check_given_settings(const Registry& registry, const Settings& settings, const std::vector<std::string>& given,
                          const std::string& scene) {
  for_named_bakes(registry, settings, scene, [&](const std::string& folder, const OwnBake& own) {
    check_given(folder, settings, own.settings, given);
  });
}

}  // namespace maquette
