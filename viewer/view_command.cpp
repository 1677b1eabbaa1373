#include <cstdlib>

#include "scenes/error.h"
#include "scenes/files.h"
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
  const std::string& screenshot = line.options.screenshot;
  if (screenshot.empty() && line.options.frames > 0)
    throw UsageError("--frames", "the window draws until it is closed; add --screenshot FILE.png");
  if (!screenshot.empty() && lower_extension(screenshot) != ".png")
    throw UsageError("--screenshot " + screenshot, "the name must end in .png");
  if (!is_set("DISPLAY") && !is_set("WAYLAND_DISPLAY"))
    throw Error("maquette view", "there is no display (DISPLAY and WAYLAND_DISPLAY are empty)",
                "maquette render --output FILE.png draws without one");
  check_replaces_none("--screenshot", screenshot, input_files(line.options));
  if (!screenshot.empty()) check_writable("--screenshot", screenshot);
  return run_window(line.options);
}

}  // namespace maquette
