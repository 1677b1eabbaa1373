#include "viewer/window_state.h"

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "review/json_reader.h"
#include "scenes/error.h"
#include "scenes/files.h"

namespace maquette {

std::string window_state_file() {
  const char* file = std::getenv("MAQUETTE_WINDOW_STATE");
  return file ? file : "";
}

void write_window_state(const std::string& file, const WindowState& state) {
  const nlohmann::ordered_json json = {
      {"frames", state.frames}, {"pictures", state.pictures}, {"averaged", state.averaged},
      {"still", state.still},   {"waiting", state.waiting},   {"work", state.work},
  };
  const std::string line = json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
  write_file_atomically(file, std::as_bytes(std::span(line)));
}

std::optional<WindowState> read_window_state(const std::string& file) {
  try {
    const nlohmann::json json = nlohmann::json::parse(read_text_file(file));
    WindowState state;
    json.at("frames").get_to(state.frames);
    json.at("pictures").get_to(state.pictures);
    json.at("averaged").get_to(state.averaged);
    json.at("still").get_to(state.still);
    json.at("waiting").get_to(state.waiting);
    json.at("work").get_to(state.work);
    return state;
  } catch (const Error&) {
    return std::nullopt;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

}  // namespace maquette
