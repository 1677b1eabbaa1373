#include "viewer/window_memory.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>

#include "review/journal.h"
#include "review/json_reader.h"
#include "review/json_text.h"
#include "scenes/error.h"
#include "scenes/files.h"

namespace maquette {

namespace {

std::string memory_file() { return state_folder() + "/window.json"; }

}  // namespace

void WindowMemory::note(const std::string& source) {
  if (source.empty() || source.starts_with("builtin:")) return;
  std::erase(recent, source);
  recent.insert(recent.begin(), source);
  if (recent.size() > kMostRecent) recent.resize(kMostRecent);
}

WindowMemory load_window_memory() {
  WindowMemory memory;
  try {
    const nlohmann::json json = json_from_text(read_text_file(memory_file()));
    JsonReader reader(json, "window.json: ");
    WindowMemory read;
    read.recent = reader.texts("recent");
    read.left_open = reader.flag("left_open");
    read.right_open = reader.flag("right_open");
    read.text_scale = reader.real("text_scale", 0.5f, 4.0f);
    read.width = reader.count("width", 0, 16384);
    read.height = reader.count("height", 0, 16384);
    memory = read;
  } catch (const std::exception&) {
  }
  std::erase_if(memory.recent, [](const std::string& file) {
    std::error_code ignored;
    return !std::filesystem::exists(file, ignored);
  });
  return memory;
}

void save_window_memory(const WindowMemory& memory) {
  try {
    const nlohmann::json json = {{"recent", memory.recent},         {"left_open", memory.left_open},
                                 {"right_open", memory.right_open}, {"text_scale", memory.text_scale},
                                 {"width", memory.width},           {"height", memory.height}};
    const std::string text = json_text(json, 1) + "\n";
    write_file_atomically(memory_file(), std::as_bytes(std::span(text.data(), text.size())));
  } catch (const Error&) {
  }
}

}  // namespace maquette
