// One declaration of the keys: the window's, the panel's and the manual's.
#include "ui/shortcuts.h"

#include <GLFW/glfw3.h>
#include <gtest/gtest.h>

#include <set>

#include "render/technique/registry.h"
#include "review/json_reader.h"
#include "test_paths.h"
#include "viewer/manual.h"
#include "viewer/window_events.h"

namespace maquette {
namespace {

std::vector<std::string> keys_of(const Shortcut& shortcut) {
  std::vector<std::string> keys;
  for (std::size_t begin = 0; begin < shortcut.keys.size();) {
    const std::size_t end = std::min(shortcut.keys.find(", ", begin), shortcut.keys.size());
    keys.push_back(shortcut.keys.substr(begin, end - begin));
    begin = end + 2;
  }
  return keys;
}

bool takes_a_digit(Command command) { return command == Command::camera || command == Command::panel; }

TEST(Shortcuts, EveryKeyHasOneCommandAndEveryCommandAKey) {
  std::set<std::string> keys;
  std::set<Command> commands;
  for (const ShortcutGroup& group : shortcut_groups())
    for (const Shortcut& shortcut : group.shortcuts) {
      commands.insert(shortcut.command);
      if (takes_a_digit(shortcut.command) || shortcut.command == Command::none) continue;
      for (const std::string& key : keys_of(shortcut)) {
        EXPECT_TRUE(keys.insert(key).second) << key;
        EXPECT_EQ(command_of(key), shortcut.command) << key;
      }
    }
  for (int command = 0; command <= static_cast<int>(Command::close); ++command)
    EXPECT_TRUE(commands.contains(static_cast<Command>(command))) << command;
  EXPECT_EQ(command_of("5"), Command::camera);
  EXPECT_EQ(command_of("Ctrl+5"), Command::panel);
  EXPECT_EQ(command_of("Ctrl+0"), Command::usual_size);
  EXPECT_EQ(command_of("0"), Command::none);
  EXPECT_EQ(command_of(""), Command::none);
}

TEST(Shortcuts, EventsAreWrittenAsTheListHasThem) {
  std::set<std::string> written;
  for (int key = 1; key <= GLFW_KEY_LAST; ++key)
    for (const bool ctrl : {false, true})
      for (const bool shift : {false, true}) {
        KeyEvent event;
        event.key = key;
        event.ctrl = ctrl;
        event.shift = shift;
        written.insert(written_key(event));
      }
  for (const ShortcutGroup& group : shortcut_groups())
    for (const Shortcut& shortcut : group.shortcuts) {
      if (shortcut.command == Command::none || takes_a_digit(shortcut.command)) continue;
      for (const std::string& key : keys_of(shortcut)) EXPECT_TRUE(written.contains(key)) << key;
    }
}

TEST(Shortcuts, TheManualListsThem) {
  const std::string manual = manual_text("keys");
  for (const ShortcutGroup& group : shortcut_groups())
    for (const Shortcut& shortcut : group.shortcuts)
      EXPECT_NE(manual.find(shortcut.keys), std::string::npos) << shortcut.keys;
}

TEST(Manual, EveryTechniqueIsDescribed) {
  const std::string source = std::string(MAQUETTE_SOURCE_DIR) + "/docs/";
  const std::string modes = read_text_file(source + "modes.md"),
                    reflections = read_text_file(source + "reflections.md");
  for (const Technique& technique : builtin_registry().techniques) {
    const std::string name = "`" + technique.name + "`";
    if (technique.kind == TechniqueKind::reflector) {
      EXPECT_NE(reflections.find("| " + name), std::string::npos) << name;
    }
    if (technique.kind != TechniqueKind::mode) continue;
    const std::size_t begin = modes.find("## " + name);
    ASSERT_NE(begin, std::string::npos) << name;
    const std::string section = modes.substr(begin, modes.find("\n## ", begin) - begin);
    for (const char* part : {"*What.*", "*When.*", "*Cost.*", "*Error.*", "*Limits.*"})
      EXPECT_NE(section.find(part), std::string::npos) << name << " " << part;
  }
}

}  // namespace
}  // namespace maquette
