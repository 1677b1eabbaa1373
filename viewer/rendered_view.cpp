#include "viewer/rendered_view.h"

#include "render/parts/parts.h"
#include "viewer/options.h"

namespace maquette {

std::string render_command(const Scene& scene, const EditorState& state) {
  const auto quoted = [](const std::string& word) {
    const bool plain =
        word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=:,./*") ==
        std::string::npos;
    if (plain && !word.empty()) return word;
    std::string out = "'";
    for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
  };
  std::string text = "maquette render " + quoted(scene.name);
  const auto option = [&](const std::string& name, const std::string& value) {
    text += " " + name + " " + quoted(value);
  };
  const auto number = [](float value) { return to_text(SettingValue(static_cast<double>(value))); };
  const auto vector = [&](const glm::vec3& v) { return number(v.x) + "," + number(v.y) + "," + number(v.z); };
  const Edits& edits = state.edits;
  const SceneOptions defaults;
  option("--env", edits.environment);
  if (edits.env_rotation_deg != 0.0f) option("--env-rotation", number(edits.env_rotation_deg));
  if (edits.env_scale != 1.0f) option("--env-scale", number(edits.env_scale));
  if (!edits.variant.empty()) option("--variant", edits.variant);
  for (const auto& [material, source] : edits.materials) option("--material", material + "=" + source);
  option("--eye", vector(state.camera.eye));
  option("--target", vector(state.camera.target));
  if (state.camera.up != glm::vec3(0.0f, 1.0f, 0.0f)) option("--up", vector(state.camera.up));
  if (state.camera.is_orthographic())
    option("--orthographic", number(state.camera.height_m));
  else
    option("--fov", number(glm::degrees(state.camera.fov_y_rad)));
  if (state.mode != defaults.mode) option("--mode", state.mode);
  for (const auto& [node, mode] : edits.part_modes) option("--mode-of", node + "=" + mode);
  if (state.reflections != defaults.reflections) option("--reflections", state.reflections);
  for (const std::string& node : edits.reflectors) option("--reflector", node);
  for (const auto& [name, value] : state.settings.changed()) option("--set", name + "=" + to_text(value));
  if (!state.auto_exposure) option("--exposure", number(state.exposure_ev));
  if (state.tonemap != defaults.tonemap) option("--tonemap", state.tonemap);
  option("--msaa", std::to_string(state.still_msaa));
  option("--output", "picture.png");
  return text;
}

}  // namespace maquette
