#include "viewer/bake_command.h"

#include <cstdio>

#include "render/technique/registry.h"
#include "viewer/btf_preparation.h"
#include "viewer/command_line.h"
#include "viewer/interrupt.h"
#include "viewer/outputs.h"
#include "viewer/print.h"
#include "viewer/progress_lines.h"
#include "viewer/session.h"

namespace maquette {

int run_bake(const CommandLine& line) {
  const BakeCommand command = builtin_registry().find_bake(line.files.front());
  SceneOptions options = line.options;
  if (line.files.size() > 1) options.scene = line.files[1];
  if (!options.output.empty()) prepare_folder("--output", options.output);
  const std::shared_ptr<Scene> scene = load_session_scene(options);
  print_warnings("", scene->warnings);
  prepare_btfs(options, *scene, false);
  const BakeRequest request{*scene,
                            find_variant(*scene, options.variant),
                            options.settings,
                            {options.materials.begin(), options.materials.end()},
                            options.output,
                            [&] { return std::make_shared<const Environment>(load_environment(options.environment)); },
                            glm::radians(options.env_rotation_deg),
                            options.env_scale,
                            options.settings_given};
  const SceneOptions usual;
  if (!command.of_light && (options.environment != usual.environment ||
                            options.env_rotation_deg != usual.env_rotation_deg || options.env_scale != usual.env_scale))
    print_line(stderr, "warning: bake %s depends on no environment; its options are not used\n", command.name.c_str());
  const InterruptGuard guard;
  command.run(request, {InterruptGuard::flag(), print_progress(),
                        [](const std::string& text) { print_line(stdout, "%s\n", text.c_str()); }});
  return 0;
}

}  // namespace maquette
