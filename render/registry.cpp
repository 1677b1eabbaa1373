#include "render/registry.h"

#include <algorithm>

#include "render/bandwidth/technique.h"
#include "render/bezier/technique.h"
#include "render/octree/technique.h"
#include "render/raytraced/technique.h"
#include "render/reference/technique.h"
#include "render/reflections/technique.h"
#include "render/sg/technique.h"
#include "render/shading/technique.h"
#include "render/splitsum/technique.h"
#include "render/triangle/technique.h"
#include "render/uniform/technique.h"
#include "scenes/error.h"
#include "scenes/suggest.h"

namespace maquette {

const std::vector<TechniqueInfo>& techniques() {
  static const std::vector<TechniqueInfo> kTechniques = {
      shading_technique(),  octree_technique(),   bandwidth_technique(), uniform_technique(),
      splitsum_technique(), sg_technique(),       reference_technique(), reflections_technique(),
      bezier_technique(),   triangle_technique(), raytraced_technique(),
  };
  return kTechniques;
}

const std::vector<LaterName>& later_modes() {
  static const std::vector<LaterName> kModes = {
      {"slf", "surface light field"},
      {"prt", "precomputed radiance transfer"},
  };
  return kModes;
}

const std::vector<LaterName>& later_settings() {
  static const std::vector<LaterName> kSettings = {
      {"slf.bake", "folder of the surface light field"},
      {"slf.texels", "side of the atlas"},
      {"prt.bake", "folder of the transfer"},
      {"prt.faces", "side of a light cube face"},
  };
  return kSettings;
}

std::vector<std::string> technique_names(TechniqueKind kind) {
  std::vector<std::string> names;
  for (const TechniqueInfo& technique : techniques())
    if (technique.kind == kind) names.push_back(technique.name);
  return names;
}

namespace {

const TechniqueInfo* find(TechniqueKind kind, const std::string& name) {
  for (const TechniqueInfo& technique : techniques())
    if (technique.kind == kind && technique.name == name) return &technique;
  return nullptr;
}

/// Throws the error for a name that is not registered: one of a later version, or unknown.
[[noreturn]] void fail(const std::string& option, const std::string& name, std::vector<std::string> known,
                       const std::vector<LaterName>& later) {
  for (const LaterName& entry : later) {
    if (entry.name == name)
      throw Error(option + " " + name, entry.help + " is not available in this version", "available: " + join(known));
    known.push_back(entry.name);
  }
  throw UsageError(option + " " + name, "there is no such name", did_you_mean(name, known));
}

}  // namespace

const TechniqueInfo& find_mode(const std::string& name) {
  if (const TechniqueInfo* technique = find(TechniqueKind::mode, name)) return *technique;
  fail("--mode", name, technique_names(TechniqueKind::mode), later_modes());
}

const TechniqueInfo* find_reflector_technique(const std::string& name) {
  if (name == "off") return nullptr;
  if (const TechniqueInfo* technique = find(TechniqueKind::reflector, name)) return technique;
  std::vector<std::string> known = technique_names(TechniqueKind::reflector);
  known.insert(known.begin(), "off");
  fail("--reflections", name, known, {});
}

}  // namespace maquette
