#pragma once

#include <map>
#include <string>
#include <vector>

namespace maquette {

struct Registry;
class Settings;

/// Keys of bakes by Bake::name(): 16 hexadecimal digits, the hash of all that the result of a bake depends on. A bake
/// is kept by its key, in the cache or in a folder.
using BakeKeys = std::map<std::string, std::string>;

bool is_bake_key(const std::string& text);

/// Names of the bakes that have keys: visibility, indirect light, and those that techniques declare for themselves.
/// Octrees have none: they are kept by scene and depth, with a hash of each brick, and what has changed is made anew.
std::vector<std::string> keyed_bakes(const Registry& registry);

/// Whether the bake of this key is whole where frames of `scene` (its name) with these settings look for it.
bool is_bake_kept(const Registry& registry, const std::string& bake, const std::string& key, const std::string& scene,
                  const Settings& settings);

}  // namespace maquette
