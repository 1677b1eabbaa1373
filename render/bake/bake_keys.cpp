#include "render/bake/bake_keys.h"

#include <algorithm>

#include "render/bake/scene_bake.h"
#include "render/indirect/indirect_kind.h"
#include "render/technique/registry.h"
#include "render/visibility/visibility_kind.h"

namespace maquette {

namespace {
constexpr const char *kVisibility = "visibility", *kIndirect = "indirect";
}  // namespace

bool is_bake_key(const std::string& text) {
  return text.size() == 16 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

std::vector<std::string> keyed_bakes(const Registry& registry) {
  std::vector<std::string> names{kIndirect, kVisibility};
  for (const Technique& technique : registry.techniques)
    if (technique.own_bake) names.push_back(technique.own_bake->name);
  std::sort(names.begin(), names.end());
  return names;
}

bool is_bake_kept(const Registry& registry, const std::string& bake, const std::string& key, const std::string& scene,
                  const Settings& settings) {
  if (bake == kVisibility) return VisibilityKind().keeps(key);
  if (bake == kIndirect) return IndirectKind().keeps(key);
  for (const Technique& technique : registry.techniques)
    if (technique.own_bake && technique.own_bake->name == bake)
      return technique.own_bake->make()->is_kept(key, scene, settings);
  return false;
}

}  // namespace maquette
