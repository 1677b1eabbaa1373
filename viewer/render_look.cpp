#include "viewer/render_look.h"

#include <cstdio>
#include <cstdlib>

#include "render/gl/context.h"
#include "scenes/image_io.h"
#include "viewer/bake_lines.h"
#include "viewer/command_line.h"
#include "viewer/look_stage.h"
#include "viewer/outputs.h"
#include "viewer/picture_command.h"
#include "viewer/print.h"
#include "viewer/progress_lines.h"
#include "viewer/review_options.h"
#include "viewer/stats.h"

namespace maquette {

namespace {

std::map<std::string, std::string> provenance(const SceneOptions& options, const Look& look,
                                              const SettledFrame& settled) {
  std::map<std::string, std::string> texts = {{"maquette.look", look.name},
                                              {"maquette.environment", look.edits.environment},
                                              {"maquette.mode", look.mode},
                                              {"maquette.seed", std::to_string(options.seed)},
                                              {"maquette.average", std::to_string(options.average)}};
  const char* told = std::getenv(kPictureCommand);
  const std::string command =
      told ? std::string(told) : picture_command(options.review, options.look, settled, options.output);
  if (!command.empty()) texts["maquette.command"] = command;
  return texts;
}

}  // namespace

int render_look(const CommandLine& line) {
  SceneOptions options = line.options;
  const Review review = *review_of(options);
  std::vector<std::string> inputs = review_sources(review);
  inputs.push_back(options.review);
  check_picture_outputs(options, inputs);
  const auto scene = std::make_shared<const Scene>(load_scene(review.scene, review.scene_of_file));
  const Look look = look_of_review(review, *scene, options);
  const GlContext context = GlContext::create_headless();
  const DeviceInfo device = query_device();
  LookStage stage(scene);
  stage.set_progress([tell = print_progress()](double share) mutable { tell("render", share); });
  SettledFrame settled;
  settled.size = {options.width, options.height, options.msaa, options.samples, options.seed};
  settled.frames = options.average;
  warn_of_bakes(options, {options.look}, options.look, look,
                [&](const std::string& bake) { return stage.bake_key(look, bake); });
  const bool png = !options.output.empty() && picture_format(options.output) == PictureFormat::png;
  const float exposure_ev = png ? stage.exposure_ev(look) : 0.0f;
  RenderReport report;
  report.frames.push_back(stage.render(look, settled));
  report.total_s = 1e-3 * report.frames.back().frame_ms;
  if (png)
    save_png(options.output, stage.renderer().read_display(exposure_ev, look.tonemap));
  else if (!options.output.empty())
    save_exr(options.output, stage.renderer().read_radiance(), provenance(options, look, settled));
  if (!options.output.empty() && options.stats != "-")
    print_line(stdout, "%s: %dx%d, look %s, mode %s\n", options.output.c_str(), options.width, options.height,
               look.name.empty() ? "as saved" : look.name.c_str(), look.mode.c_str());
  options.scene = review.scene;
  if (!options.stats.empty()) write_text(options.stats, stats_json(options, stage.request(), device, report));
  return 0;
}

}  // namespace maquette
