#pragma once

#include <functional>
#include <string>
#include <vector>

#include "viewer/measure/measure_options.h"
#include "viewer/options.h"

namespace maquette {

/// The parsed command line. Names and numbers are checked; files are opened later.
struct CommandLine {
  std::string command = "view";
  std::vector<std::string> files;  ///< positional arguments
  SceneOptions options;
  MeasureOptions measure;
  bool sheet = false;                     ///< `render`: one picture of several materials and environments
  std::vector<std::string> environments;  ///< all that `--env` gave
  bool json = false;
  bool markdown = false;
  bool vocabulary = false;
  bool man = false;
  std::string completion;  ///< of this shell
  bool version = false;
  bool help = false;
};

struct CommandDeclaration {
  std::string name;
  std::string arguments;  ///< as in `SCENE`; empty without
  int min_files = 0;
  int max_files = 0;
  std::string help;
  std::string later;  ///< not empty: the command arrives with a later version; says what it needs
};
const std::vector<CommandDeclaration>& command_declarations();

/// One option, declared once: parser, `--help` and manual come from it.
struct OptionDeclaration {
  std::string name;      ///< `--mode`
  std::string argument;  ///< `MODE`; empty for a flag
  std::string help;
  std::vector<std::string> commands;
  std::function<void(CommandLine*, const std::string&)> apply;  ///< throws UsageError for a bad value
  bool repeatable = false;
  std::string alias = {};                 ///< `-o`
  std::vector<std::string> choices = {};  ///< of its argument, where they can be listed; for completion in a shell
};
const std::vector<OptionDeclaration>& option_declarations();
bool belongs_to(const OptionDeclaration& option, const std::string& command);

/// `arguments` without the program's name. Throws UsageError (unknown command, option or value: the nearest names) and
/// Error (a name that arrives with a later version).
CommandLine parse_command_line(const std::vector<std::string>& arguments);

}  // namespace maquette
