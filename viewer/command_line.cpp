#include "viewer/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>

#include "render/btf/btf_source.h"
#include "render/technique/registry.h"
#include "review/review.h"
#include "scenes/error.h"
#include "scenes/suggest.h"

namespace maquette {

namespace {

std::string bake_names() {
  std::vector<std::string> names, later;
  for (const BakeCommand& command : builtin_registry().bakes()) names.push_back(command.name);
  for (const LaterName& mode : builtin_registry().later_modes) later.push_back(mode.name);
  return join(names) + (later.empty() ? ""
                                      : " (" + join(later, " and ") + (later.size() == 1 ? " arrives" : " arrive") +
                                            " with a later version)");
}

}  // namespace

const std::vector<CommandDeclaration>& command_declarations() {
  static const std::vector<CommandDeclaration> kCommands = {
      {"view", "[SCENE|REVIEW]", 0, 1,
       "a scene or a review in a window (maquette FILE does the same); without one the built-in cockpit", ""},
      {"render", "[SCENE|REVIEW]", 0, 1, "one frame, or a look of a review, without a window, to .exr or .png", ""},
      {"bake", "KIND [SCENE]", 1, 2,
       "precomputes what a technique needs: " + bake_names() +
           "; resumes where it was stopped, and builds only what has changed",
       ""},
      {"play", "PATH.path.json [SCENE] | REVIEW | SCENE", 1, 2,
       "a camera path of a file or, by --path, of a review, or a scene's --animation: settled frame by settled frame "
       "to a folder or a video; the "
       "same command continues where it stopped",
       ""},
      {"report", "[SCENE|REVIEW]", 0, 1,
       "error against run time of every technique: report.html, report.json, report.csv and charts in a folder; the "
       "same "
       "command continues where it stopped",
       ""},
      {"compare", "A.exr B.exr", 2, 2, "error of A against the reference B", ""},
      {"measure", "[SCENE|REVIEW]", 0, 1,
       "what a pane of glass adds to what an eye sees: luminances, reflectances, angles, regions and sweeps, as JSON "
       "or CSV",
       ""},
      {"inspect", "FILE [SCENE]", 1, 2,
       "what is in a scene, BRDF, environment, review or bake (its folder; SCENE: the one that it was baked of), what "
       "it would need, and the frame plan; `library` lists the built-in materials and environments",
       ""},
      {"doctor", "", 0, 0, "graphics context, limits, libraries; what will not work here and why", ""},
      {"help", "[WORD]", 0, 1,
       "the manual, or its part about a command, a topic (settings, modes, scenes, light, keys, files) or a setting",
       ""},
  };
  return kCommands;
}

bool belongs_to(const OptionDeclaration& option, const std::string& command) {
  return option.commands.empty() ||
         std::find(option.commands.begin(), option.commands.end(), command) != option.commands.end();
}

namespace {

const CommandDeclaration& find_command(const std::string& name) {
  std::vector<std::string> names;
  for (const CommandDeclaration& command : command_declarations()) {
    if (command.name == name) return command;
    names.push_back(command.name);
  }
  throw UsageError(name, "there is no such command", did_you_mean(name, names));
}

/// Whether a first argument names a scene or a review: `maquette FILE` is `maquette view FILE`.
bool names_file(const std::string& word) {
  if (word.starts_with("builtin:") || word.find_first_of("./") != std::string::npos) return true;
  const auto& commands = command_declarations();
  const auto same = [&](const CommandDeclaration& command) { return command.name == word; };
  std::error_code ignored;
  return std::none_of(commands.begin(), commands.end(), same) && std::filesystem::exists(word, ignored);
}

/// What other programs call some options.
std::string option_for(const std::string& word) {
  static const std::map<std::string, std::string> kOptions = {
      {"--environment", "--env"}, {"--hdri", "--env"},           {"--rotation", "--env-rotation"},
      {"--resolution", "--size"}, {"--width", "--size"},         {"--height", "--size"},
      {"--spp", "--samples"},     {"--paths", "--samples"},      {"--quality", "--samples"},
      {"--seconds", "--time"},    {"--renderer", "--mode"},      {"--technique", "--mode"},
      {"--lookat", "--target"},   {"--position", "--eye"},       {"--antialiasing", "--msaa"},
      {"--setting", "--set"},     {"--mirror", "--reflections"}, {"--threshold", "--target-error"}};
  std::vector<std::string> words;
  for (const auto& [known, option] : kOptions) words.push_back(known);
  const std::vector<std::string> near = nearest_names(word, words, 1);
  return near.empty() || edit_distance(word, near.front()) > 2 ? std::string() : kOptions.at(near.front());
}

/// The error for an argument that the command does not accept.
UsageError unexpected(const std::string& argument, const CommandDeclaration& command) {
  if (!argument.starts_with('-')) {
    const std::string takes = command.arguments.empty() ? "no arguments" : command.arguments;
    return UsageError(argument, "one argument too many", "maquette " + command.name + " takes " + takes);
  }
  const std::string name = argument.substr(0, argument.find('='));
  std::vector<std::string> names;
  for (const OptionDeclaration& option : option_declarations()) {
    if (belongs_to(option, command.name)) names.push_back(option.name);
    if (option.name == name || (!option.alias.empty() && option.alias == name))
      return UsageError(name, "this option is not one of maquette " + command.name,
                        "it belongs to " + join(option.commands));
  }
  std::vector<std::string> near = nearest_names(name, names);
  const std::string meant = option_for(name);
  if (std::find(names.begin(), names.end(), meant) != names.end()) near = {meant};
  return UsageError(
      name, "there is no such option",
      near.empty() ? "maquette " + command.name + " --help lists them" : "did you mean " + join(near, " or ") + "?");
}

/// Throws UsageError where options stand before a command: they would be those of `view`, and the command its scene.
void check_command_comes_first(const std::vector<std::string>& arguments) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& word = arguments[i];
    if (!word.starts_with('-')) {
      for (const CommandDeclaration& command : command_declarations())
        if (command.name == word)
          throw UsageError(arguments.front(), "it stands before the command",
                           "options come behind it: maquette " + word + " " + arguments.front() + " ...");
      return;
    }
    for (const OptionDeclaration& option : option_declarations())
      if ((option.name == word || option.alias == word) && !option.argument.empty()) ++i;
  }
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

/// The texts given for one option, in order; a flag counts as one empty text.
struct GivenOption {
  const OptionDeclaration* declaration;
  std::vector<std::string> texts;
  bool flag = false;
};

std::vector<GivenOption> collect(const std::vector<std::string>& arguments, const CommandDeclaration& command,
                                 std::vector<std::string>* files) {
  CLI::App app;
  app.set_help_flag();
  app.allow_extras();
  std::vector<GivenOption> given;
  for (const OptionDeclaration& option : option_declarations())
    if (belongs_to(option, command.name)) given.push_back({&option, {}, false});
  for (GivenOption& option : given) {
    const std::string names =
        option.declaration->name + (option.declaration->alias.empty() ? "" : "," + option.declaration->alias);
    if (option.declaration->argument.empty())
      app.add_flag(names, option.flag);
    else
      app.add_option(names, option.texts)
          ->expected(1)
          ->allow_extra_args(false)
          ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  }
  // CLI11 expects the arguments in reverse order.
  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());
  try {
    app.parse(reversed);
  } catch (const CLI::ParseError& error) {
    throw UsageError("", one_line(error.what()), "maquette " + command.name + " --help");
  }
  for (const std::string& extra : app.remaining()) {
    const bool is_option = extra.size() > 1 && extra.starts_with('-');
    if (is_option || static_cast<int>(files->size()) >= command.max_files) throw unexpected(extra, command);
    files->push_back(extra);
  }
  return given;
}

void check_combinations(const CommandLine& line) {
  const SceneOptions& options = line.options;
  if (options.fov_deg && options.orthographic_m)
    throw UsageError("--orthographic", "it does not go with --fov", "give one of them");
  if (!options.camera.empty() && options.eye)
    throw UsageError("--camera", "it excludes --eye", "leave one of them out");
  if (options.up && glm::length(*options.up) == 0.0f) throw UsageError("--up", "it has no direction");
  if (options.eye && options.target && *options.eye == *options.target)
    throw UsageError("--target", "it is where the eye is");
  if (line.command == "play" && !line.help && options.output.empty())
    throw UsageError("", "play needs a folder or a video to write to", "add --output FOLDER or FILE.mp4");
  if (line.command == "report" && !line.help && options.output.empty())
    throw UsageError("", "report needs a folder to write to", "add --output FOLDER");
  if (line.environments.size() > 1 && !line.sheet)
    throw UsageError("--env", "it is given twice", "give it once, or add --sheet");
  if (line.command != "render" || line.help) return;
  if (options.output.empty() && options.stats.empty())
    throw UsageError("", "render needs a file to write to", "add --output FILE.exr or FILE.png");
  if (!options.reflectors.empty() && options.reflections == kNoReflections)
    throw UsageError("--reflector " + options.reflectors.front(), "nothing reflects while --reflections is off",
                     "add --reflections, one of " + join(builtin_registry().names(TechniqueKind::reflector)));
  const bool accumulates = options.time_s || options.target_error;
  if (options.frames > 0 && accumulates)
    throw UsageError("--frames", "it excludes --time and --target-error", "leave one out");
}

/// Scene, review and path among the arguments.
void take_files(CommandLine* line) {
  SceneOptions& options = line->options;
  const bool views =
      line->command == "view" || line->command == "render" || line->command == "report" || line->command == "measure";
  if (line->files.empty() || (!views && line->command != "play")) return;
  const std::string& first = line->files.front();
  if (is_review_file(first)) {
    options.review = first;
    if (line->files.size() > 1) throw UsageError(line->files[1], "one argument too many", "the review names its scene");
    if (line->command == "play" && options.path.empty())
      throw UsageError("maquette play", "it needs to know which path of the review", "add --path NAME");
  } else if (views) {
    options.scene = first;
    options.given.insert("SCENE");
  } else {
    if (!options.path.empty()) throw UsageError("--path", "it is for a review", "give a .maquette.json file");
    const bool is_path = first.ends_with(".path.json") || line->files.size() > 1 || options.animation.name.empty();
    if (is_path) options.path = first;
    if (line->files.size() > 1) options.scene = line->files[1];
    if (!is_path) options.scene = first;
  }
  if (line->command == "play" && !options.path.empty() && !options.camera.empty())
    throw UsageError("--camera", "a path has its own cameras", "leave it out");
}

/// A settled frame is the same however long it takes: no clock ends it, nothing is measured.
void check_settled(const CommandLine& line) {
  for (const char* name : {"--time", "--target-error", "--frames", "--view", "--reference"})
    if (line.options.given.contains(name))
      throw UsageError(name, "reviews and sheets are drawn as settled frames",
                       "use --average N and --samples N instead");
}

}  // namespace

CommandLine parse_command_line(const std::vector<std::string>& arguments) {
  CommandLine line;
  std::vector<std::string> rest = arguments;
  if (!rest.empty() && !rest.front().empty() && !rest.front().starts_with('-') && !names_file(rest.front())) {
    line.command = find_command(rest.front()).name;
    rest.erase(rest.begin());
  } else if (!rest.empty() && (rest.front() == "--help" || rest.front() == "-h" || rest.front() == "--version")) {
    line.command = "help";
  } else {
    check_command_comes_first(rest);
  }
  const CommandDeclaration& command = find_command(line.command);
  if (line.command == "report" || line.command == "measure") {  // many pictures, or many rays: small by default
    line.options.width = 320;
    line.options.height = 180;
  }
  if (!command.later.empty() && std::find(rest.begin(), rest.end(), "--help") == rest.end())
    throw Error("maquette " + command.name, "this command is not available in this version", command.later);
  for (const GivenOption& option : collect(rest, command, &line.files)) {
    if (option.texts.size() > 1 && !option.declaration->repeatable)
      throw UsageError(option.declaration->name, "it is given twice");
    for (const std::string& text : option.texts) {
      if (text.empty())
        throw UsageError(option.declaration->name, "its value is empty",
                         "give " + option.declaration->argument + " or leave the option out");
      option.declaration->apply(&line, text);
    }
    if (option.flag) option.declaration->apply(&line, {});
    if (option.flag || !option.texts.empty()) line.options.given.insert(option.declaration->name);
  }
  if (std::find(line.files.begin(), line.files.end(), "") != line.files.end())
    throw UsageError("maquette " + command.name, "one of its arguments is empty", "it takes " + command.arguments);
  if (!line.help && static_cast<int>(line.files.size()) < command.min_files)
    throw UsageError("maquette " + command.name, "it needs " + command.arguments);
  take_files(&line);
  if (!line.options.look.empty() && line.options.review.empty())
    throw UsageError("--look " + line.options.look, "there is no review to take it from", "give a .maquette.json file");
  for (auto& [name, source] : line.options.materials) source = with_btf_reading(source, line.options.settings);
  check_combinations(line);
  if (line.command == "render" && (line.sheet || !line.options.review.empty())) check_settled(line);
  return line;
}

}  // namespace maquette
