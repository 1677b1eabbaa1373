#include "viewer/shell_completion.h"

#include "scenes/error.h"
#include "viewer/command_line.h"
#include "viewer/manual.h"

namespace maquette {

namespace {

std::string words_of(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

std::vector<std::string> option_words(const std::string& command) {
  std::vector<std::string> words;
  for (const OptionDeclaration& option : option_declarations()) {
    if (!belongs_to(option, command)) continue;
    words.push_back(option.name);
    if (!option.alias.empty()) words.push_back(option.alias);
  }
  return words;
}

/// What stands behind an option: `--mode|-m`.
std::string pattern_of(const OptionDeclaration& option) {
  return option.name + (option.alias.empty() ? "" : "|" + option.alias);
}

std::string bash_completion() {
  std::vector<std::string> commands;
  std::string options, values, taking;
  for (const CommandDeclaration& command : command_declarations()) {
    commands.push_back(command.name);
    options += "      " + command.name + ") words=\"" + words_of(option_words(command.name)) + "\" ;;\n";
  }
  for (const OptionDeclaration& option : option_declarations()) {
    if (option.argument.empty()) continue;
    if (!option.choices.empty())
      values += "    " + pattern_of(option) + ") words=\"" + words_of(option.choices) + "\" ;;\n";
  }
  return R"(# bash completion of maquette, made by `maquette help --completion bash`
_maquette() {
  local cur=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} command=view word words=
  local commands=")" +
         words_of(commands) + R"("
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    case " $commands " in *" $word "*) command=$word; break ;; esac
  done
  COMPREPLY=()
  case $previous in
)" + values +
         R"(  esac
  if [ -z "$words" ] && [[ $cur == -* ]]; then
    case $command in
)" + options +
         R"(    esac
  elif [ -z "$words" ] && [ "$COMP_CWORD" -eq 1 ]; then
    words=$commands
  fi
  [ -z "$words" ] || mapfile -t COMPREPLY < <(compgen -W "$words" -- "$cur")
  [[ ${#COMPREPLY[@]} -eq 1 && ${COMPREPLY[0]} == *= ]] && compopt -o nospace 2>/dev/null
  [[ ${#COMPREPLY[@]} -gt 0 || $cur == -* ]] || mapfile -t COMPREPLY < <(compgen -f -- "$cur")
} && complete -o filenames -F _maquette maquette
)";
}

/// Text within single quotes and brackets of a specification of _arguments.
std::string zsh_text(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\'')
      result += "'\\''";
    else if (c == '[' || c == ']' || c == ':' || c == '\\')
      result += std::string("\\") + c;
    else
      result += c;
  }
  return result;
}

std::string zsh_completion() {
  std::string text =
      "#compdef maquette\n# zsh completion of maquette, made by `maquette help --completion zsh`\n"
      "_maquette() {\n  local -a commands\n  commands=(\n";
  for (const CommandDeclaration& command : command_declarations())
    text += "    '" + zsh_text(command.name) + ":" + zsh_text(command.help) + "'\n";
  text +=
      "  )\n  if (( CURRENT == 2 )) && [[ $words[2] != -* ]]; then\n    _describe command commands\n    _files\n"
      "    return\n  fi\n  case $words[2] in\n";
  std::string by_default;
  for (const CommandDeclaration& command : command_declarations()) {
    std::string specifications;
    for (const OptionDeclaration& option : option_declarations()) {
      if (!belongs_to(option, command.name)) continue;
      for (const std::string& name : {option.name, option.alias}) {
        if (name.empty()) continue;
        std::string one = std::string(option.repeatable ? "*" : "") + name + "[" + zsh_text(option.help) + "]";
        if (!option.argument.empty())
          one += ":" + zsh_text(option.argument) + ":" +
                 (option.choices.empty() ? "_files" : "(" + words_of(option.choices) + ")");
        specifications += " \\\n        '" + one + "'";
      }
    }
    const std::string call = "_arguments" + specifications + " \\\n        '*:file:_files'";
    text += "    " + command.name + ")\n      " + call + "\n      ;;\n";
    if (command.name == "view") by_default = call;
  }
  return text + "    *)\n      " + by_default + "\n      ;;\n  esac\n}\n_maquette \"$@\"\n";
}

/// Text in roff: no escapes, no requests at the begin of a line.
std::string roff(const std::string& text) {
  std::string result;
  for (const char c : text)
    result += c == '\\' ? std::string("\\e") : c == '-' ? std::string("\\-") : std::string(1, c);
  return result.starts_with('.') || result.starts_with('\'') ? "\\&" + result : result;
}

}  // namespace

std::string shell_completion(const std::string& shell) {
  if (shell == "bash") return bash_completion();
  if (shell == "zsh") return zsh_completion();
  throw UsageError("--completion " + shell, "there is no completion for this shell", "give bash or zsh");
}

std::string manual_roff() {
  std::string text =
      ".TH MAQUETTE 1 \"\" \"maquette " MAQUETTE_VERSION
      "\" \"User Commands\"\n.SH NAME\nmaquette \\- viewer of virtual prototypes, measured materials "
      "under real light\n.SH SYNOPSIS\n.B maquette\n[\\fICOMMAND\\fR] [\\fIFILE\\fR] [\\fIOPTIONS\\fR]\n";
  for (const ManualSection& section : manual_sections()) {
    text += ".SH \"" + roff(section.title) + "\"\n";
    if (!section.text.empty()) text += roff(section.text) + "\n";
    for (const ManualEntry& entry : section.entries)
      text += ".TP\n\\fB" + roff(entry.term) + "\\fR\n" + roff(entry.help) + "\n";
  }
  return text;
}

}  // namespace maquette
