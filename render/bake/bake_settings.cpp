#include "render/bake/bake_settings.h"

#include <algorithm>
#include <filesystem>
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

Settings with_settings_of(const std::string& folder, Settings settings, const std::vector<std::string>& names) {
  constexpr std::size_t kLargest = 1u << 16u;
  const std::string file = settings_file(folder);
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return settings;
  try {
    const std::vector<std::byte> bytes = read_file(file, kLargest);
    std::istringstream lines(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    for (std::string line; std::getline(lines, line);) {
      const std::string name = line.substr(0, line.find('='));
      if (std::ranges::find(names, name) == names.end() || settings.changed().contains(name)) continue;
      settings.set_from_text(name, line.substr(std::min(name.size() + 1, line.size())));
    }
  } catch (const Error&) {  // damaged: the bake's own check says what does not fit
  }
  return settings;
}

Settings with_settings_of_bakes(const Registry& registry, Settings settings, const std::string& scene) {
  for (const std::string& mode : registry.names(TechniqueKind::mode)) {
    const auto& own = registry.find_mode(mode).own_bake;
    if (!own || !find_setting(own->name + ".bake")) continue;
    const std::string folder = settings.get_string(own->name + ".bake");
    if (folder.empty()) continue;
    const auto within = std::filesystem::path(folder) / (bake_name_of_scene(scene) + "-" + own->name);
    settings = with_settings_of(folder, std::move(settings), own->settings);
    settings = with_settings_of(within.string(), std::move(settings), own->settings);
  }
  return settings;
}

}  // namespace maquette
