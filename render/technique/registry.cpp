#include "render/technique/registry.h"

#include "render/bandwidth/technique.h"
#include "render/bezier/technique.h"
#include "render/btf/technique.h"
#include "render/ground/technique.h"
#include "render/octree/technique.h"
#include "render/prt/technique.h"
#include "render/raytraced/technique.h"
#include "render/reference/technique.h"
#include "render/reflections/technique.h"
#include "render/sg/technique.h"
#include "render/shading/technique.h"
#include "render/slf/technique.h"
#include "render/splitsum/technique.h"
#include "render/triangle/technique.h"
#include "render/uniform/technique.h"
#include "scenes/error.h"
#include "scenes/suggest.h"

namespace maquette {

const Registry& builtin_registry() {
  static const Registry kRegistry{.techniques =
                                      {
                                          shading_technique(),
                                          btf_technique(),
                                          ground_technique(),
                                          octree_technique(),
                                          bandwidth_technique(),
                                          uniform_technique(),
                                          splitsum_technique(),
                                          sg_technique(),
                                          slf_technique(),
                                          prt_technique(),
                                          reference_technique(),
                                          reflections_technique(),
                                          bezier_technique(),
                                          triangle_technique(),
                                          raytraced_technique(),
                                      },
                                  .default_mode = "bandwidth"};
  return kRegistry;
}

namespace {

const Technique* find(const std::vector<Technique>& techniques, TechniqueKind kind, const std::string& name) {
  for (const Technique& technique : techniques)
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

const Technique& Registry::find_mode(const std::string& name, const std::string& option) const {
  if (const Technique* technique = find(techniques, TechniqueKind::mode, name)) return *technique;
  fail(option, name, names(TechniqueKind::mode), later_modes);
}

const Technique* Registry::find_reflector(const std::string& name) const {
  if (name == kNoReflections) return nullptr;
  if (name == kAutoReflections) return first_that(TechniqueKind::reflector, &Capabilities::is_exact);
  if (const Technique* technique = find(techniques, TechniqueKind::reflector, name)) return technique;
  std::vector<std::string> known = names(TechniqueKind::reflector);
  known.insert(known.begin(), {kNoReflections, kAutoReflections});
  fail("--reflections", name, known, {});
}

std::vector<std::string> Registry::names(TechniqueKind kind) const {
  std::vector<std::string> found;
  for (const Technique& technique : techniques)
    if (technique.kind == kind) found.push_back(technique.name);
  return found;
}

const Technique* Registry::first_that(TechniqueKind kind, bool Capabilities::*capability) const {
  for (const Technique& technique : techniques)
    if (technique.kind == kind && technique.can.*capability) return &technique;
  return nullptr;
}

std::vector<BakeCommand> Registry::bakes() const {
  std::vector<BakeCommand> all;
  for (const Technique& technique : techniques) all.insert(all.end(), technique.bakes.begin(), technique.bakes.end());
  return all;
}

BakeCommand Registry::find_bake(const std::string& name) const {
  std::vector<std::string> known;
  for (const BakeCommand& command : bakes()) {
    if (command.name == name) return command;
    known.push_back(command.name);
  }
  for (const LaterName& later : later_modes) {
    if (later.name == name) throw Error("maquette bake " + name, "this bake is not available in this version");
    known.push_back(later.name);
  }
  throw UsageError("maquette bake " + name, "there is no such bake", did_you_mean(name, known));
}

std::vector<DebugViewInfo> Registry::views() const {
  std::vector<DebugViewInfo> all;
  for (const Technique& technique : techniques) all.insert(all.end(), technique.views.begin(), technique.views.end());
  return all;
}

}  // namespace maquette
