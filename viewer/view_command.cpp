#include <cstdlib>

#include "scenes/error.h"
#include "viewer/command_line.h"
#include "viewer/commands.h"
#include "viewer/outputs.h"
#include "viewer/window.h"

namespace maquette {

namespace {

bool is_set(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr && *value != 0;
}

}  // namespace

int run_view(const CommandLine& line) {
  if (!is_set("DISPLAY") && !is_set("WAYLAND_DISPLAY"))
    throw Error("maquette view", "there is no display (DISPLAY and WAYLAND_DISPLAY are empty)",
                "maquette render --output FILE.png draws without one");
  check_replaces_none("--screenshot", line.options.screenshot, input_files(line.options));
  if (!line.options.screenshot.empty()) check_writable("--screenshot", line.options.screenshot);
  return run_window(line.options);
}

}  // namespace maquette
