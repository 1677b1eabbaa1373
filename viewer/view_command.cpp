#include <cstdlib>

#include "scenes/error.h"
#include "viewer/command_line.h"
#include "viewer/commands.h"

namespace maquette {

namespace {

bool is_set(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr && *value != 0;
}

}  // namespace

int run_view(const CommandLine&) {
  if (!is_set("DISPLAY") && !is_set("WAYLAND_DISPLAY"))
    throw Error("maquette view", "there is no display (DISPLAY and WAYLAND_DISPLAY are empty)",
                "maquette render --output FILE.png draws without one");
  throw Error("maquette view", "the window is not available in this build", "use maquette render --output FILE.png");
}

}  // namespace maquette
