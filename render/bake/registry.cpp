#include "render/bake/registry.h"

#include "render/octree/bake_command.h"
#include "render/technique/registry.h"
#include "scenes/error.h"
#include "scenes/suggest.h"

namespace maquette {

const std::vector<BakeCommand>& bake_commands() {
  static const std::vector<BakeCommand> kCommands = {octree_bake_command()};
  return kCommands;
}

const BakeCommand& find_bake_command(const std::string& name) {
  std::vector<std::string> known;
  for (const BakeCommand& command : bake_commands()) {
    if (command.name == name) return command;
    known.push_back(command.name);
  }
  for (const LaterName& later : later_modes()) {
    if (later.name == name) throw Error("maquette bake " + name, "this bake is not available in this version");
    known.push_back(later.name);
  }
  throw UsageError("maquette bake " + name, "there is no such bake", did_you_mean(name, known));
}

}  // namespace maquette
