#include "viewer/bake_command.h"

#include <cstdio>

#include "render/technique/registry.h"
#include "viewer/command_line.h"
#include "viewer/interrupt.h"
#include "viewer/outputs.h"
#include "viewer/session.h"

namespace maquette {

namespace {

/// A line on standard error whenever another tenth is done.
std::function<void(const std::string&, double)> print_progress() {
  return [shown = std::string(), tenths = -1](const std::string& what, double share) mutable {
    const int percent = static_cast<int>(100.0 * share);
    if (what == shown && percent / 10 == tenths) return;
    shown = what;
    tenths = percent / 10;
    std::fprintf(stderr, "%s: %d %%\n", what.c_str(), percent);
  };
}

}  // namespace

int run_bake(const CommandLine& line) {
  const BakeCommand command = builtin_registry().find_bake(line.files.front());
  SceneOptions options = line.options;
  if (line.files.size() > 1) options.scene = line.files[1];
  if (!options.output.empty()) prepare_folder("--output", options.output);
  const std::shared_ptr<Scene> scene = load_session_scene(options);
  for (const std::string& warning : scene->warnings) std::fprintf(stderr, "warning: %s\n", warning.c_str());
  const BakeRequest request{*scene,
                            find_variant(*scene, options.variant),
                            options.settings,
                            {options.materials.begin(), options.materials.end()},
                            options.output,
                            [&] { return std::make_shared<const Environment>(load_environment(options.environment)); },
                            glm::radians(options.env_rotation_deg),
                            options.env_scale};
  const InterruptGuard guard;
  command.run(request, {InterruptGuard::flag(), print_progress(),
                        [](const std::string& text) { std::printf("%s\n", text.c_str()); }});
  return 0;
}

}  // namespace maquette
