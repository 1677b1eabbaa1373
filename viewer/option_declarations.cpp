#include <cmath>
#include <set>

#include "render/renderer.h"
#include "render/technique/registry.h"
#include "scenes/environment.h"
#include "scenes/error.h"
#include "scenes/suggest.h"
#include "viewer/command_line.h"
#include "viewer/measure/measure_declarations.h"
#include "viewer/option_values.h"

namespace maquette {

namespace {

constexpr int kMaxSide = 16384;

glm::vec3 parse_point(const std::string& text, const std::string& what) {
  const std::vector<double> v = parse_list(text, what, 3, "x,y,z");
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
}

glm::vec4 parse_section(const std::string& text) {
  const std::vector<double> v = parse_list(text, "--section", 4, "x,y,z,M");
  const double length = glm::length(glm::dvec3(v[0], v[1], v[2]));
  if (!(length > 0.0)) throw UsageError("--section", "the normal has no direction");
  return glm::vec4(glm::dvec4(v[0], v[1], v[2], v[3]) / length);
}

void parse_size(SceneOptions* options, const std::string& text) {
  const std::size_t x = text.find('x');
  const bool has_sides =
      x != std::string::npos && x > 0 && x + 1 < text.size() && text.find('x', x + 1) == std::string::npos;
  if (!has_sides || text.find_first_not_of("0123456789x") != std::string::npos)
    throw UsageError("--size", "\"" + text + "\" is not of the form WxH",
                     "write width and height in pixels, as 1280x720");
  options->width = static_cast<int>(parse_count(text.substr(0, x), "--size", 1, kMaxSide));
  options->height = static_cast<int>(parse_count(text.substr(x + 1), "--size", 1, kMaxSide));
}

void parse_dent(SceneOptions* options, const std::string& text) {
  const std::vector<double> v = parse_list(text, "--dent", 5, "x,y,z,depth,radius");
  if (!(v[4] > 0.0)) throw UsageError("--dent", "the radius must be above 0");
  options->dents.push_back({{static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])},
                            static_cast<float>(v[3]),
                            static_cast<float>(v[4])});
}

void parse_turn(SceneOptions* options, const std::string& text) {
  const auto [node, numbers] = parse_pair(text, "--turn", "NODE=x,y,z,DEG", true);
  const std::vector<double> v = parse_list(numbers, "--turn", 4, "x,y,z,DEG");
  const glm::dvec3 axis(v[0], v[1], v[2]);
  if (!(glm::length(axis) > 0.0)) throw UsageError("--turn", "the axis has no direction");
  options->turns.push_back({node, glm::vec3(glm::normalize(axis)), static_cast<float>(v[3])});
}

void parse_animation(SceneOptions* options, const std::string& text) {
  std::size_t equals = text.rfind('=');
  // A name may have one, too: behind that of a time is a number.
  if (equals != std::string::npos && text.find_first_not_of("0123456789.+-eE", equals + 1) != std::string::npos)
    equals = std::string::npos;
  options->animation.name = text.substr(0, equals);
  if (equals != std::string::npos)
    options->animation.time_s = parse_in(text.substr(equals + 1), "--animation", 0.0, 86400.0);
  if (options->animation.name.empty()) throw UsageError("--animation", "the name is empty", "write NAME or NAME=S");
}

const std::string& check_name(const std::string& text, const std::string& what, const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (name == text) return text;
  throw UsageError(what, "there is no \"" + text + "\"", did_you_mean(text, names));
}

const std::string& check_file_name(const std::string& text, const std::string& what) {
  if (text.empty()) throw UsageError(what, "the file name is empty");
  return text;
}

void parse_msaa(SceneOptions* options, const std::string& text) {
  options->msaa = static_cast<int>(parse_count(text, "--msaa", 1, 16));
  if (options->msaa != 1 && options->msaa != 4 && options->msaa != 16)
    throw UsageError("--msaa", text + " samples a pixel are not offered", "use 1, 4 or 16");
}

using Apply = std::function<void(SceneOptions*, const std::string&)>;

/// An option of `view`, `render`, `report` and `measure`.
OptionDeclaration shared(std::string name, std::string argument, std::string help, const Apply& apply,
                         bool repeatable = false) {
  return {std::move(name),
          std::move(argument),
          std::move(help),
          {"view", "render", "report", "measure"},
          [apply](CommandLine* line, const std::string& text) { apply(&line->options, text); },
          repeatable};
}

/// An option of `inspect` as well: it shapes the frame plan.
OptionDeclaration plan_option(OptionDeclaration option) {
  option.commands = {"view", "render", "report", "measure", "inspect"};
  return option;
}

/// An option of `view` and `render`, not of `report`, which varies it.
OptionDeclaration one_picture(OptionDeclaration option) {
  std::erase(option.commands, "report");
  return option;
}

/// An option of `bake` as well: it shapes what is precomputed.
OptionDeclaration bake_option(OptionDeclaration option) {
  option.commands.emplace_back("bake");
  return option;
}

OptionDeclaration render_only(std::string name, std::string argument, std::string help, const Apply& apply) {
  OptionDeclaration option = shared(std::move(name), std::move(argument), std::move(help), apply);
  option.commands = {"render"};
  return option;
}

OptionDeclaration chosen(OptionDeclaration option, std::vector<std::string> choices) {
  option.choices = std::move(choices);
  return option;
}

std::vector<std::string> reflections_choices() {
  std::vector<std::string> names = builtin_registry().names(TechniqueKind::reflector);
  names.insert(names.begin(), {"off", "auto"});
  return names;
}

std::vector<std::string> setting_choices() {
  std::vector<std::string> names;
  for (const SettingDeclaration& setting : setting_declarations()) names.push_back(setting.name + "=");
  return names;
}

/// Notes all that it gives, for a sheet.
OptionDeclaration several_environments(OptionDeclaration option) {
  option.repeatable = true;
  option.apply = [one = option.apply](CommandLine* line, const std::string& text) {
    one(line, text);
    line->environments.push_back(text);
  };
  return option;
}

std::string environment_choices() {
  std::vector<std::string> names;
  for (const std::string& name : builtin_environment_names()) names.push_back("builtin:" + name);
  return join(names);
}

std::vector<OptionDeclaration> light_and_material_options() {
  using O = SceneOptions;
  return {
      several_environments(
          bake_option(shared("--env", "FILE",
                             "environment: .hdr, .exr or " + environment_choices() +
                                 " (builtin:clear-sky); builtin:clear-sky:DEG has the sun so high",
                             [](O* o, const std::string& t) { o->environment = check_file_name(t, "--env"); }))),
      bake_option(shared("--env-rotation", "DEG", "rotates the environment about +Y, from +Z towards +X",
                         [](O* o, const std::string& t) {
                           o->env_rotation_deg = static_cast<float>(parse_in(t, "--env-rotation", -36000.0, 36000.0));
                         })),
      bake_option(shared("--env-scale", "X", "cd/m2 per stored unit (1)",
                         [](O* o, const std::string& t) {
                           o->env_scale = static_cast<float>(parse_in(t, "--env-scale", 0.0, 1e12));
                         })),
      shared("--exposure", "EV",
             "stops; only of the picture for the eye, never of .exr (what suits the environment, more where the "
             "picture is dark, less where lamps glare)",
             [](O* o, const std::string& t) {
               o->exposure_ev = static_cast<float>(parse_in(t, "--exposure", -64.0, 64.0));
             }),
      chosen(shared("--tonemap", "NAME", join(tonemap_names()) + " (pbr-neutral)",
                    [](O* o, const std::string& t) { o->tonemap = check_name(t, "--tonemap", tonemap_names()); }),
             tonemap_names()),
      bake_option(shared(
          "--material", "NAME=FILE",
          "gives the material of that name (* for all) a measured BRDF: MERL .binary, builtin:LIBRARY-NAME, "
          "builtin:glass; or a BTF: a folder of images, .btf, builtin:btf-leather; `maquette inspect library` lists "
          "the library",
          [](O* o, const std::string& t) {
            o->materials.push_back(parse_name_and_file(t, "--material", "NAME=FILE"));
            if (o->materials.back().second.empty())
              throw UsageError("--material", "\"" + t + "\" names no FILE; leave the option out to keep the material");
          },
          true)),
      bake_option(plan_option(shared("--scene", "NAME", "scene of a glTF file, by name or index (its default)",
                                     [](O* o, const std::string& t) { o->scene_of_file = t; }))),
      bake_option(plan_option(
          shared("--variant", "NAME", "variant of the scene", [](O* o, const std::string& t) { o->variant = t; }))),
  };
}

/// NODE=MODE; the last '=' counts, as nodes may have one in their names.
PartMode parse_part_mode(const std::string& text) {
  const std::size_t split = text.rfind('=');
  if (split == std::string::npos || split == 0 || split + 1 == text.size())
    throw UsageError("--mode-of", "\"" + text + "\" is not NODE=MODE",
                     "for example --mode-of Seat=" + builtin_registry().default_mode);
  const PartMode part{text.substr(0, split), text.substr(split + 1)};
  builtin_registry().find_mode(part.mode, "--mode-of");
  return part;
}

std::vector<OptionDeclaration> camera_options() {
  using O = SceneOptions;
  return {
      shared("--camera", "NAME", "camera of the scene (its first one)",
             [](O* o, const std::string& t) { o->camera = t; }),
      shared("--eye", "x,y,z", "eye in metres, instead of --camera",
             [](O* o, const std::string& t) { o->eye = parse_point(t, "--eye"); }),
      shared("--target", "x,y,z", "point to look at (the middle of the scene)",
             [](O* o, const std::string& t) { o->target = parse_point(t, "--target"); }),
      shared("--up", "x,y,z", "direction that is up in the picture (0,1,0)",
             [](O* o, const std::string& t) { o->up = parse_point(t, "--up"); }),
      shared("--fov", "DEG", "vertical field of view",
             [](O* o, const std::string& t) { o->fov_deg = static_cast<float>(parse_in(t, "--fov", 0.1, 170.0)); }),
      shared("--orthographic", "M", "parallel rays, M metres from the picture's bottom to its top, instead of --fov",
             [](O* o, const std::string& t) {
               o->orthographic_m = static_cast<float>(parse_in(t, "--orthographic", 1e-9, 1e9));
             }),
      shared("--section", "x,y,z,M",
             "section plane: only points p with x px + y py + z pz <= M metres are seen; shadows, light and mirror "
             "images stay whole",
             [](O* o, const std::string& t) { o->section = parse_section(t); }),
      shared("--size", "WxH", "picture in pixels (1280x720; `report`, `measure`: 320x180)", parse_size),
  };
}

std::vector<OptionDeclaration> quality_options() {
  using O = SceneOptions;
  return {
      one_picture(shared(
          "--samples", "N", "shading samples a shaded pixel, scaled where a mode predicts them (64)",
          [](O* o, const std::string& t) { o->samples = static_cast<int>(parse_count(t, "--samples", 1, 65536)); })),
      one_picture(shared("--seed", "N", "of the sample sequence (0)",
                         [](O* o, const std::string& t) {
                           o->seed = static_cast<std::uint32_t>(parse_count(t, "--seed", 0, 4294967295));
                         })),
      plan_option(shared("--msaa", "N", "samples a pixel: 1, 4 or 16 (1: rays through pixel centres)", parse_msaa)),
      one_picture(shared(
          "--frames", "N",
          "`render`: measures N frames after warm-up, each without results of earlier frames (see shading.reuse); the "
          "time is their median; `view`: frames before --screenshot",
          [](O* o, const std::string& t) { o->frames = static_cast<int>(parse_count(t, "--frames", 1, 1000000)); })),
      render_only(
          "--target-error", "X",
          "averages frames until the relative RMSE is X: against --reference, else as far as it is noise of the frames",
          [](O* o, const std::string& t) { o->target_error = parse_in(t, "--target-error", 1e-6, 10.0); }),
      render_only("--time", "S",
                  "averages frames for S seconds, shaders and bakes not counted (with --target-error: at most)",
                  [](O* o, const std::string& t) { o->time_s = parse_in(t, "--time", 1e-3, 86400.0); }),
      one_picture(shared(
          "--view", "NAME", "a debug view instead of the picture: " + join(Renderer::debug_view_names()),
          [](O* o, const std::string& t) { o->debug_view = check_name(t, "--view", Renderer::debug_view_names()); })),
      bake_option(shared("--dent", "x,y,z,depth,radius", "presses a dent into the subdivision surfaces there (metres)",
                         parse_dent, true)),
      bake_option(plan_option(shared("--turn", "NODE=x,y,z,DEG",
                                     "turns a node with what is below it about an axis through its origin; *: all that "
                                     "is drawn, about that of the "
                                     "world",
                                     parse_turn, true))),
      bake_option(plan_option(
          shared("--animation", "NAME=S",
                 "the scene's animation at S seconds (0); `play`: NAME alone plays along the path, or for its duration "
                 "where there is none",
                 parse_animation))),
      chosen(bake_option(plan_option(shared(
                 "--set", "SETTING=VALUE", "any setting of the list below",
                 [](O* o, const std::string& t) {
                   const auto [name, value] = parse_pair(t, "--set", "SETTING=VALUE");
                   o->settings.set_from_text(name, value);
                   o->settings_given.push_back(name);
                 },
                 true))),
             setting_choices()),
  };
}

std::vector<OptionDeclaration> technique_options() {
  using O = SceneOptions;
  return {
      chosen(one_picture(plan_option(
                 shared("--mode", "MODE",
                        "shading mode: " + join(builtin_registry().names(TechniqueKind::mode)) + " (" +
                            builtin_registry().default_mode + ")",
                        [](O* o, const std::string& t) { o->mode = builtin_registry().find_mode(t).name; }))),
             builtin_registry().names(TechniqueKind::mode)),
      one_picture(plan_option(shared(
          "--mode-of", "NODE=MODE",
          "shading mode of a node, by name or path (names from a root joined by /), and of what is below it; of nested "
          "ones the innermost counts",
          [](O* o, const std::string& t) { o->part_modes.push_back(parse_part_mode(t)); }, true))),
      chosen(one_picture(plan_option(shared(
                 "--reflections", "NAME",
                 "reflector technique of mirrors and glass: off, auto (the exact one, where there is a reflector), " +
                     join(builtin_registry().names(TechniqueKind::reflector)) + " (auto)",
                 [](O* o, const std::string& t) {
                   builtin_registry().find_reflector(t);
                   o->reflections = t;
                 }))),
             reflections_choices()),
      shared(
          "--reflector", "NODE",
          "node that reflects, instead of those that the scene marks (all its panes where it marks none)",
          [](O* o, const std::string& t) { o->reflectors.push_back(t); }, true),
      shared("--look", "NAME", "look of a review (the state that it was saved in)",
             [](O* o, const std::string& t) { o->look = t; }),
  };
}

/// Of reviews, paths and sheets: what is drawn besides one picture.
std::vector<OptionDeclaration> series_options() {
  return {
      {"--path",
       "NAME",
       "path of the review",
       {"play"},
       [](CommandLine* line, const std::string& t) { line->options.path = t; }},
      {"--fps",
       "N",
       "frames a second (25)",
       {"play"},
       [](CommandLine* line, const std::string& t) { line->options.fps = parse_in(t, "--fps", 0.01, 1000.0); }},
      {"--format",
       "NAME",
       "of the frames: png (tone mapped) or exr (linear) (png)",
       {"play"},
       [](CommandLine* line, const std::string& t) {
         line->options.frame_format = check_name(t, "--format", {"png", "exr"});
       }},
      {"--sheet",
       "",
       "one picture of all sources that --material NAME=FILE gives to one material (columns) under all --env (rows); "
       "--size is that of one",
       {"render"},
       [](CommandLine* line, const std::string&) { line->sheet = true; }},
      {"--average",
       "N",
       "frames that are averaged to one picture of a review or a path (1)",
       {"render", "play"},
       [](CommandLine* line, const std::string& t) {
         line->options.average = static_cast<int>(parse_count(t, "--average", 1, 65536));
       }},
  };
}

std::vector<OptionDeclaration> output_options() {
  using O = SceneOptions;
  OptionDeclaration output = render_only(
      "--output", "FILE",
      "`render`: .exr (linear, cd/m2) or .png (tone mapped); `compare`: the difference, .png (FLIP in false "
      "colours) or .exr (absolute, R, G, B); `play`: .mp4, .mkv, .mov, or the folder "
      "of the frames; `report`, `bake`: the folder; `measure`: .json or .csv",
      [](O* o, const std::string& t) { o->output = check_file_name(t, "--output"); });
  output.commands = {"render", "play", "compare", "report", "bake", "measure"};
  output.alias = "-o";
  return {
      output,
      {"--screenshot",
       "FILE.png",
       "the whole window after --frames drawn frames (1); then it closes",
       {"view"},
       [](CommandLine* line, const std::string& t) { line->options.screenshot = check_file_name(t, "--screenshot"); }},
      render_only("--stats", "FILE.json", "writes what the frame cost and why (- for standard output)",
                  [](O* o, const std::string& t) { o->stats = check_file_name(t, "--stats"); }),
      {"--budget",
       "S",
       "seconds for the whole report; what does not fit is listed (600)",
       {"report"},
       [](CommandLine* line, const std::string& t) { line->options.budget_s = parse_in(t, "--budget", 5.0, 86400.0); }},
      {"--repeats",
       "N",
       "measurements of each point of the report, of different seeds (3)",
       {"report"},
       [](CommandLine* line, const std::string& t) {
         line->options.repeats = static_cast<int>(parse_count(t, "--repeats", 1, 100));
       }},
      render_only("--reference", "FILE.exr", "adds the error against this picture to the stats",
                  [](O* o, const std::string& t) { o->reference = check_file_name(t, "--reference"); }),
      {"--json",
       "",
       "prints one JSON object",
       {"compare", "inspect", "doctor", "measure"},
       [](CommandLine* line, const std::string&) { line->json = true; }},
      {"--version",
       "",
       "prints the program's version",
       {"help"},
       [](CommandLine* line, const std::string&) { line->version = true; }},
      {"--markdown",
       "",
       "prints it as docs/manual.md holds it",
       {"help"},
       [](CommandLine* line, const std::string&) { line->markdown = true; }},
      {"--man",
       "",
       "prints it as a page for man",
       {"help"},
       [](CommandLine* line, const std::string&) { line->man = true; }},
      chosen({"--completion",
              "SHELL",
              "prints the completion of commands and options for bash or zsh",
              {"help"},
              [](CommandLine* line, const std::string& t) { line->completion = t; }},
             {"bash", "zsh"}),
      {"--vocabulary",
       "",
       "prints docs/vocabulary.md, the words of plan and stats",
       {"help"},
       [](CommandLine* line, const std::string&) { line->vocabulary = true; }},
  };
}

/// Options of `render` that are those of `play` as well.
bool decides_settled_frames(const std::string& name) {
  static const std::set<std::string> kNames = {
      "--env",   "--env-rotation", "--env-scale", "--exposure",    "--tonemap",   "--material",
      "--scene", "--variant",      "--size",      "--samples",     "--seed",      "--msaa",
      "--set",   "--mode",         "--mode-of",   "--reflections", "--reflector", "--dent",
      "--look",  "--section",      "--animation", "--turn",        "--camera"};
  return kNames.contains(name);
}

}  // namespace

const std::vector<OptionDeclaration>& option_declarations() {
  static const std::vector<OptionDeclaration> kOptions = [] {
    std::vector<OptionDeclaration> all;
    for (const auto& group : {output_options(), series_options(), technique_options(), light_and_material_options(),
                              camera_options(), quality_options(), measure_option_declarations()})
      all.insert(all.end(), group.begin(), group.end());
    for (OptionDeclaration& option : all)  // what only a picture for the eye has
      if (option.name == "--exposure" || option.name == "--tonemap" || option.name == "--view")
        std::erase(option.commands, "measure");
    for (OptionDeclaration& option : all)
      if (decides_settled_frames(option.name)) option.commands.emplace_back("play");
    all.push_back({"--help",
                   "",
                   "this manual, or that of one command",
                   {},
                   [](CommandLine* line, const std::string&) { line->help = true; },
                   false,
                   "-h"});
    return all;
  }();
  return kOptions;
}

}  // namespace maquette
