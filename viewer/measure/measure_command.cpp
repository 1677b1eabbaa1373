#include <cstdio>

#include "scenes/angles.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/ground.h"
#include "scenes/harmless.h"
#include "viewer/btf_preparation.h"
#include "viewer/command_line.h"
#include "viewer/commands.h"
#include "viewer/inspection_options.h"
#include "viewer/interrupt.h"
#include "viewer/measure/measure_files.h"
#include "viewer/outputs.h"
#include "viewer/print.h"
#include "viewer/progress_lines.h"
#include "viewer/review_options.h"
#include "viewer/session.h"

namespace maquette {

namespace {

void check_outputs(const CommandLine& line) {
  const SceneOptions& options = line.options;
  std::vector<std::string> others = input_files(options);
  check_replaces_none("--output", options.output, others);
  others.push_back(options.output);
  check_replaces_none("--layers", line.measure.layers, others);
  if (!options.output.empty()) {
    const std::string extension = lower_extension(options.output);
    if (extension != ".json" && extension != ".csv")
      throw UsageError("--output " + options.output, "the name must end in .json or .csv");
    check_writable("--output", options.output);
  }
  if (line.measure.layers.empty()) return;
  if (lower_extension(line.measure.layers) != ".exr")
    throw UsageError("--layers " + line.measure.layers, "the name must end in .exr");
  check_writable("--layers", line.measure.layers);
}

}  // namespace

int run_measure(const CommandLine& line) {
  check_outputs(line);
  SceneOptions options = line.options;
  if (line.measure.eye && options.eye) throw UsageError("--eye-point", "it excludes --eye", "leave one of them out");
  MeasureOptions measured = line.measure;
  const std::optional<Review> review = review_of(options);
  if (review) take_review(&options);
  const std::shared_ptr<const Scene> scene = load_session_scene(options);
  if (review) measured = measure_options_of(*review, *scene, line.options, measured);
  if (measured.eye) measured.eye->right_hand_drive = measured.right_hand_drive;
  if (measured.night && measured.lux_on_glass)
    throw UsageError("--night", "it excludes --lux-on-glass", "leave one of them out");
  const auto environment = std::make_shared<const Environment>(load_environment(options.environment));
  print_warnings("", scene->warnings);
  print_warnings(environment->name, environment->warnings);
  prepare_btfs(options, *scene);
  const std::shared_ptr<const Scene> drawn =
      with_ground(scene, *environment, options.settings, radians(options.env_rotation_deg));
  const InterruptGuard guard;
  const auto tell = print_progress();
  LastEye last;
  const Measurement result = measure(
      options, measured, drawn, environment,
      [&](double share) {
        if (share > 0.0) tell("measure", share);
      },
      &last);
  if (!options.output.empty())
    write_text(options.output,
               lower_extension(options.output) == ".csv" ? measurement_csv(result) : measurement_json(result));
  if (!measured.layers.empty()) write_layers(measured.layers, result, last);
  if (line.json)
    std::fputs(harmless_json(measurement_json(result)).c_str(), stdout);
  else
    print_text(stdout, measurement_text(result));
  return 0;
}

}  // namespace maquette
