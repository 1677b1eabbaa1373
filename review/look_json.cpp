#include "review/look_json.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "render/picture/tonemap.h"
#include "review/json_reader.h"
#include "scenes/error.h"

namespace maquette {

using Json = nlohmann::json;

namespace {

const char* const kMetered = "auto";

Json point_json(const glm::vec3& p) { return {shortest(p.x), shortest(p.y), shortest(p.z)}; }

glm::vec3 point_from(JsonReader* reader, const std::string& key) {
  const std::vector<float> v = reader->reals(key, 3);
  return {v[0], v[1], v[2]};
}

Json settings_json(const Settings& settings) {
  Json json = Json::object();
  for (const SettingDeclaration& declaration : setting_declarations())
    std::visit([&](const auto& value) { json[declaration.name] = value; }, settings.get(declaration.name));
  return json;
}

/// Settings that the file does not have keep their defaults: they came with a later version.
Settings settings_from_json(const Json& json, const std::string& where) {
  Settings settings;
  for (const auto& [name, value] : json.items()) {
    const SettingDeclaration* declaration = find_setting(name);
    try {
      if (value.is_boolean())
        settings.set(name, value.get<bool>());
      else if (value.is_string())
        settings.set(name, value.get<std::string>());
      else if (value.is_number() && declaration && std::holds_alternative<double>(declaration->default_value))
        settings.set(name, value.get<double>());
      else if (value.is_number_integer())
        settings.set(name, value.get<int>());
      else
        throw Error(name, "a number, a text, true or false is expected");
    } catch (const Error& error) {
      throw Error(where, error.what());
    }
  }
  return settings;
}

Json dents_json(const std::vector<Dent>& dents) {
  Json json = Json::array();
  for (const Dent& dent : dents)
    json.push_back({{"center", point_json(dent.center)},
                    {"depth_m", shortest(dent.depth_m)},
                    {"radius_m", shortest(dent.radius_m)},
                    {"part", dent.part}});
  return json;
}

std::vector<Dent> dents_from_json(const Json& json, const std::string& where) {
  std::vector<Dent> dents;
  for (std::size_t i = 0; i < json.size(); ++i) {
    JsonReader reader(json[i], where + "[" + std::to_string(i) + "]");
    Dent dent;
    dent.center = point_from(&reader, "center");
    dent.depth_m = reader.real("depth_m");
    dent.radius_m = reader.real("radius_m", 1e-9f);
    dent.part = reader.text("part");
    reader.finish();
    dents.push_back(dent);
  }
  return dents;
}

Json turns_json(const std::vector<NodeTurn>& turns) {
  Json json = Json::array();
  for (const NodeTurn& turn : turns)
    json.push_back({{"node", turn.node}, {"axis", point_json(turn.axis)}, {"angle_deg", shortest(turn.angle_deg)}});
  return json;
}

std::vector<NodeTurn> turns_from_json(const Json& json, const std::string& where) {
  std::vector<NodeTurn> turns;
  for (std::size_t i = 0; i < json.size(); ++i) {
    const std::string here = where + "[" + std::to_string(i) + "]";
    JsonReader reader(json[i], here);
    NodeTurn turn;
    turn.node = reader.text("node");
    turn.axis = point_from(&reader, "axis");
    turn.angle_deg = reader.real("angle_deg", -36000.0f, 36000.0f);
    reader.finish();
    if (!(glm::length(turn.axis) > 0.0f)) throw Error(here + ".axis", "it has no direction");
    turns.push_back(turn);
  }
  return turns;
}

Json animation_json(const PlayedAnimation& animation) {
  if (animation.name.empty()) return nullptr;
  return {{"name", animation.name}, {"time_s", animation.time_s}};
}

PlayedAnimation animation_from_json(const Json& json, const std::string& where) {
  PlayedAnimation animation;
  if (json.is_null()) return animation;
  JsonReader reader(json, where);
  animation.name = reader.text("name");
  animation.time_s = reader.number("time_s", 0.0, 86400.0);
  reader.finish();
  return animation;
}

Json section_json(const glm::vec4& section) {
  if (section == glm::vec4(0.0f)) return nullptr;
  return {{"normal", point_json(glm::vec3(section))}, {"offset_m", shortest(section.w)}};
}

glm::vec4 section_from_json(const Json& json, const std::string& where) {
  if (json.is_null()) return glm::vec4(0.0f);
  JsonReader reader(json, where);
  const glm::vec3 normal = point_from(&reader, "normal");
  const float offset_m = reader.real("offset_m");
  reader.finish();
  if (std::abs(glm::length(normal) - 1.0f) > 1e-3f)
    throw Error(where + ".normal", "its length is not 1", "divide it by its length");
  return {normal, offset_m};
}

std::map<std::string, std::string> map_from_json(const Json& json, const std::string& where) {
  std::map<std::string, std::string> map;
  for (const auto& [key, value] : json.items()) {
    if (!value.is_string()) throw Error(where + "." + key, "a text in quotes is expected");
    map[key] = value.get<std::string>();
  }
  return map;
}

std::set<std::string> set_of(const std::vector<std::string>& texts) { return {texts.begin(), texts.end()}; }

void check_mode(const std::string& mode, const std::string& where) {
  try {
    builtin_registry().find_mode(mode, where);
  } catch (const UsageError& error) {
    throw Error("", error.what());  // the file is wrong, not the call
  }
}

}  // namespace

Json camera_json(const CameraView& camera) {
  return {{"eye", point_json(camera.eye)},         {"target", point_json(camera.target)},
          {"up", point_json(camera.up)},           {"fov_y_rad", shortest(camera.fov_y_rad)},
          {"height_m", shortest(camera.height_m)}, {"near_m", shortest(camera.near_m)},
          {"far_m", shortest(camera.far_m)},       {"aspect", shortest(camera.aspect)}};
}

CameraView camera_from_json(const Json& json, const std::string& where) {
  JsonReader reader(json, where);
  CameraView camera;
  camera.eye = point_from(&reader, "eye");
  camera.target = point_from(&reader, "target");
  camera.up = point_from(&reader, "up");
  camera.fov_y_rad = reader.real("fov_y_rad", 1e-4f, 3.1415f);
  camera.height_m = reader.real("height_m", 0.0f);
  camera.near_m = reader.real("near_m", 0.0f);
  camera.far_m = reader.real("far_m", 0.0f);
  camera.aspect = reader.real("aspect", 0.0f);
  reader.finish();
  if (camera.eye == camera.target) throw Error(where + ".target", "it is where the eye is");
  if (camera.up == glm::vec3(0.0f)) throw Error(where + ".up", "it has no direction");
  return camera;
}

Json look_json(const Look& look, const SourceMap& to_file) {
  const Edits& edits = look.edits;
  Json materials = Json::object();
  for (const auto& [name, source] : edits.materials) materials[name] = to_file(source);
  Json modes = Json::object();
  for (const auto& [path, mode] : edits.part_modes) modes[path] = mode;
  return {{"name", look.name},
          {"note", look.note},
          {"environment",
           {{"source", to_file(edits.environment)},
            {"rotation_deg", shortest(edits.env_rotation_deg)},
            {"scale", shortest(edits.env_scale)}}},
          {"variant", edits.variant},
          {"materials", materials},
          {"dents", dents_json(edits.dents)},
          {"animation", animation_json(edits.animation)},
          {"turns", turns_json(edits.turns)},
          {"hidden", edits.hidden_nodes},
          {"reflectors", edits.reflectors},
          {"section", section_json(edits.section)},
          {"part_modes", modes},
          {"camera", camera_json(look.camera)},
          {"mode", look.mode},
          {"reflections", look.reflections},
          {"settings", settings_json(look.settings)},
          {"exposure_ev", look.auto_exposure ? Json(kMetered) : shortest(look.exposure_ev)},
          {"tonemap", look.tonemap}};
}

Look look_from_json(const Json& json, const std::string& where, const SourceMap& from_file) {
  JsonReader reader(json, where);
  Look look;
  Edits& edits = look.edits;
  look.name = reader.text("name");
  look.note = reader.text("note");
  JsonReader environment(reader.member("environment"), reader.where("environment"));
  edits.environment = from_file(environment.text("source"));
  edits.env_rotation_deg = environment.real("rotation_deg", -36000.0f, 36000.0f);
  edits.env_scale = environment.real("scale", 0.0f, 1e12f);
  environment.finish();
  edits.variant = reader.text("variant");
  for (const auto& [name, source] : map_from_json(reader.object("materials"), reader.where("materials")))
    edits.materials[name] = from_file(source);
  edits.dents = dents_from_json(reader.list("dents"), reader.where("dents"));
  if (reader.has("animation"))
    edits.animation = animation_from_json(reader.member("animation"), reader.where("animation"));
  if (reader.has("turns")) edits.turns = turns_from_json(reader.list("turns"), reader.where("turns"));
  edits.hidden_nodes = set_of(reader.texts("hidden"));
  edits.reflectors = set_of(reader.texts("reflectors"));
  if (reader.has("section")) edits.section = section_from_json(reader.member("section"), reader.where("section"));
  edits.part_modes = map_from_json(reader.object("part_modes"), reader.where("part_modes"));
  for (const auto& [path, mode] : edits.part_modes) check_mode(mode, reader.where("part_modes"));
  look.camera = camera_from_json(reader.member("camera"), reader.where("camera"));
  look.mode = reader.text("mode");
  check_mode(look.mode, reader.where("mode"));
  std::vector<std::string> reflections = builtin_registry().names(TechniqueKind::reflector);
  reflections.insert(reflections.end(), {kNoReflections, kAutoReflections});
  look.reflections = reader.choice("reflections", reflections);
  look.settings = settings_from_json(reader.object("settings"), reader.where("settings"));
  look.auto_exposure = reader.member("exposure_ev") == kMetered;
  if (!look.auto_exposure) look.exposure_ev = reader.real("exposure_ev", -64.0f, 64.0f);
  look.tonemap = reader.choice("tonemap", tonemap_names());
  reader.finish();
  return look;
}

}  // namespace maquette
