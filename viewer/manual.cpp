#include "viewer/manual.h"

#include <cstdio>
#include <functional>
#include <map>

#include "render/technique/registry.h"
#include "scenes/error.h"
#include "scenes/suggest.h"
#include "ui/shortcuts.h"
#include "viewer/command_line.h"
#include "viewer/commands.h"
#include "viewer/shell_completion.h"
#include "viewer/vocabulary_page.h"

namespace maquette {

namespace {

constexpr std::size_t kTextColumns = 80;
constexpr std::size_t kIndent = 2;
constexpr std::size_t kHelpColumn = 28;

using Entry = ManualEntry;
using Section = ManualSection;

std::string range_text(const SettingDeclaration& setting) {
  if (!setting.choices.empty()) return join(setting.choices, " | ");
  if (std::holds_alternative<bool>(setting.default_value)) return "true | false";
  if (setting.min == setting.max)
    return std::holds_alternative<std::string>(setting.default_value) ? "text" : "a number";
  return to_text(setting.min) + " to " + to_text(setting.max) + (setting.unit.empty() ? "" : " " + setting.unit);
}

Section command_section() {
  Section section{"Commands", "", {{"maquette", "the built-in cockpit in a window"}}};
  for (const CommandDeclaration& command : command_declarations()) {
    const std::string arguments = command.arguments.empty() ? "" : " " + command.arguments;
    section.entries.push_back({"maquette " + command.name + arguments,
                               command.help + (command.later.empty() ? "" : "; not available in this version")});
  }
  return section;
}

Section option_section(const std::string& command) {
  Section section{"Options", "", {}};
  if (command.empty()) section.text = "Of view and render, where nothing else is said. The default is in parentheses.";
  for (const OptionDeclaration& option : option_declarations()) {
    if (!command.empty() && !belongs_to(option, command)) continue;
    const bool usual = option.commands.empty() || (option.commands.size() > 1 && belongs_to(option, "view"));
    std::string help = option.help;
    if (option.repeatable) help += "; may be repeated";
    if (command.empty() && !usual) help += " [" + join(option.commands) + "]";
    const std::string alias = option.alias.empty() ? "" : option.alias + ", ";
    section.entries.push_back({alias + option.name + (option.argument.empty() ? "" : " " + option.argument), help});
  }
  return section;
}

Section mode_section() {
  Section section{"Shading modes", "", {}};
  for (const Technique& technique : builtin_registry().techniques)
    if (technique.kind == TechniqueKind::mode) section.entries.push_back({technique.name, technique.help});
  for (const LaterName& later : builtin_registry().later_modes)
    section.entries.push_back({later.name, later.help + "; not available in this version"});
  return section;
}

Section setting_section() {
  Section section{"Settings", "Given by --set SETTING=VALUE.", {}};
  for (const SettingDeclaration& setting : setting_declarations())
    section.entries.push_back({setting.name, setting.help + " [" + range_text(setting) + "; default " +
                                                 to_text(setting.default_value) + "]"});
  return section;
}

Section scene_section() {
  return {
      "Scenes",
      "SCENE is a .gltf or .glb file, or one of these. The cockpit's cameras are driver, passenger, exterior and door.",
      {{"builtin:cockpit", "a car interior with its door and windshield, life size (the default)"},
       {"builtin:sphere", "a unit sphere at the origin"},
       {"builtin:plate", "four statues of matte, plastic, paint and metal on a marble-textured floor"},
       {"builtin:cornell", "a box with coloured walls, open to the viewer"},
       {"builtin:seat", "a seat in an open box with a red wall and a mirror wall, below a lamp"},
       {"builtin:open-seat", "a seat on a turntable, under the sky alone"}}};
}

Section light_section() {
  return {
      "Light and shadow",
      "What shading.visibility and shading.indirect show in the modes that take samples.",
      {{"auto", "as rays"},
       {"rays",
        "suns, lamps and what else is bright are shadowed by a ray from every point, traced on the processor: panes "
        "and cut-outs count, edges are as sharp as the picture. The rest of the sky is as with baked where "
        "surfaces hide it from each other, else unshadowed; while nothing moves, rays correct it until it is exact. A "
        "quarter of a moving frame's time; at rest a frame takes about twice that with baked. No octree is built. Left "
        "out: while something moves, what mirrors show is as with baked"},
       {"baked",
        "the environment alone, by maps of 0.22 rad a vertex: a few milliseconds a frame, after seconds of baking. "
        "Left out: shadows of lamps, edges sharper than the mesh; the sun leaks by a cell"},
       {"traced",
        "every sample's ray goes through the octree: lamps too. Several times the frame's time, after tens of seconds "
        "of baking; surfaces are as fine as its cells, and panes do not dim"},
       {"none", "no shadows: the paper's model, and what the report's estimator errors are of. Costs nothing"},
       {"indirect baked",
        "light from surface to surface, all bounces, by vertex; with every kind of shadows. A few milliseconds a "
        "frame, after seconds of baking. Left out: caustics, what is finer than the mesh"},
       {"indirect none", "what no light sees directly is black. Costs nothing"}}};
}

Section file_section() {
  return {"Files and environment",
          "",
          {{"MAQUETTE_CACHE",
            "folder of derived tables, kept by content; empty: none are kept. Without it "
            "$XDG_CACHE_HOME/maquette or ~/.cache/maquette. It can be removed at any time"},
           {"MAQUETTE_WINDOW_STATE",
            "a file that the window writes after each of its frames, for programs that drive it: one line of JSON with "
            "the frames it has shown, the pictures of the scene it has drawn, how many are averaged in the one shown, "
            "whether that is still, the events that wait, and the work in the background"},
           {"GLIBC_TUNABLES",
            "the program restarts itself with glibc.malloc.hugetlb=1 added to it, so that memory comes in large "
            "pages; glibc.malloc.hugetlb=0 prevents this, for example for debuggers"},
           {".exr", "linear Rec.709 in stored units times --env-scale, alpha 0 where only the sky is seen"},
           {".png", "opaque; exposure, then the tone mapper, then the mean over the samples of a pixel, then sRGB"},
           {"--stats", "one JSON object; docs/vocabulary.md says what its names mean"}}};
}

Section key_section() {
  Section section{"Keys", "Mouse and keys of the window, which lists them too (F1).", {}};
  for (const ShortcutGroup& group : shortcut_groups())
    for (const Shortcut& shortcut : group.shortcuts) section.entries.push_back({shortcut.keys, shortcut.what});
  return section;
}

Section exit_section() {
  return {"Exit codes",
          "An error is one line on standard error that names the file and what to do.",
          {{"0", "done"}, {"1", "the work failed"}, {"2", "the call was wrong"}}};
}

/// Parts of the manual by one word.
std::map<std::string, std::function<Section()>> topics() {
  return {{"settings", setting_section}, {"modes", mode_section}, {"scenes", scene_section},
          {"light", light_section},      {"files", file_section}, {"commands", command_section},
          {"keys", key_section}};
}

/// The settings of that name, or of the technique named so.
Section settings_named(const std::string& name) {
  Section section = setting_section();
  std::erase_if(section.entries, [&](const Entry& entry) {
    return entry.term != name && !entry.term.starts_with(name.ends_with('.') ? name : name + ".");
  });
  return section;
}

std::vector<Section> sections(const std::string& command) {
  if (command.empty())
    return {command_section(), option_section(command), scene_section(), mode_section(), setting_section(),
            light_section(),   key_section(),           file_section(),  exit_section()};
  std::vector<Section> chosen = {option_section(command)};
  if (command == "view" || command == "render" || command == "inspect" || command == "measure") {
    chosen.push_back(scene_section());
    chosen.push_back(mode_section());
    chosen.push_back(setting_section());
    chosen.push_back(light_section());
  }
  return chosen;
}

/// `text` broken at spaces, every line but the first indented to `column`; the first starts there already.
std::string wrap(const std::string& text, std::size_t column) {
  std::string result;
  std::size_t used = column;
  std::size_t begin = 0;
  while (begin < text.size()) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    const bool first = used == column;
    if (!first && used + 1 + word.size() > kTextColumns) {
      result += "\n" + std::string(column, ' ') + word;
      used = column + word.size();
    } else {
      result += (first ? "" : " ") + word;
      used += word.size() + (first ? 0 : 1);
    }
    begin = end + 1;
  }
  return result;
}

std::string section_text(const Section& section) {
  std::string text = section.title + "\n";
  if (!section.text.empty()) text += std::string(kIndent, ' ') + wrap(section.text, kIndent) + "\n";
  for (const Entry& entry : section.entries) {
    std::string line = std::string(kIndent, ' ') + entry.term;
    if (line.size() + 2 > kHelpColumn)
      line += "\n" + std::string(kHelpColumn, ' ');
    else
      line.resize(kHelpColumn, ' ');
    text += line + wrap(entry.help, kHelpColumn) + "\n";
  }
  return text + "\n";
}

/// Escapes text for a table cell, which a bar would end.
std::string cell(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '|' ? std::string("\\|") : std::string(1, c);
  return result;
}

}  // namespace

std::vector<ManualSection> manual_sections() { return sections({}); }

std::string manual_text(const std::string& command) {
  std::string text;
  if (command.empty()) {
    text = "maquette: a viewer of virtual prototypes, measured materials under real light\n\n";
  } else {
    const CommandDeclaration* found = nullptr;
    std::vector<std::string> names;
    for (const auto& [topic, section] : topics()) {
      names.push_back(topic);
      if (topic == command) return section_text(section());
    }
    if (const Section section = settings_named(command); !section.entries.empty()) return section_text(section);
    for (const SettingDeclaration& setting : setting_declarations()) names.push_back(setting.name);
    for (const CommandDeclaration& candidate : command_declarations()) {
      names.push_back(candidate.name);
      if (candidate.name == command) found = &candidate;
    }
    if (found == nullptr)
      throw UsageError(command, "there is no such command, topic or setting", did_you_mean(command, names));
    text = "maquette " + found->name + (found->arguments.empty() ? "" : " " + found->arguments) + "\n" +
           std::string(kIndent, ' ') + wrap(found->help, kIndent) + "\n\n";
  }
  for (const Section& section : sections(command)) text += section_text(section);
  text.pop_back();
  return text;
}

std::string manual_markdown() {
  std::string text =
      "# Manual\n\nMade by `maquette help --markdown` from the declarations that the program itself reads; a test "
      "keeps it "
      "current.\n";
  for (const Section& section : sections({})) {
    text += "\n## " + section.title + "\n\n";
    if (!section.text.empty()) text += section.text + "\n\n";
    text += "| | |\n|---|---|\n";
    for (const Entry& entry : section.entries) text += "| `" + cell(entry.term) + "` | " + cell(entry.help) + " |\n";
  }
  return text;
}

int run_help(const CommandLine& line) {
  if (line.version)
    std::printf("maquette %s\n", MAQUETTE_VERSION);
  else if (line.markdown)
    std::fputs(manual_markdown().c_str(), stdout);
  else if (line.man)
    std::fputs(manual_roff().c_str(), stdout);
  else if (!line.completion.empty())
    std::fputs(shell_completion(line.completion).c_str(), stdout);
  else if (line.vocabulary)
    std::fputs(vocabulary_markdown().c_str(), stdout);
  else
    std::fputs(manual_text(line.command != "help" ? line.command
                           : line.files.empty()   ? ""
                                                  : line.files.front())
                   .c_str(),
               stdout);
  return 0;
}

}  // namespace maquette
