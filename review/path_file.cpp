// `NAME.path.json`, and paths within a review.
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

#include "review/camera_path.h"
#include "review/json_reader.h"
#include "review/json_text.h"
#include "review/look_json.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/json_fault.h"

namespace maquette {

using Json = nlohmann::json;

namespace {

constexpr int kPathFormat = 1;
constexpr double kLongest_s = 86400.0;
const std::vector<std::string> kEases = {"linear", "in", "out", "smooth"};

Json optional_json(const std::optional<float>& value) { return value ? shortest(*value) : Json(nullptr); }

std::optional<float> optional_from(JsonReader* reader, const std::string& key, float limit) {
  if (reader->member(key).is_null()) return std::nullopt;
  return reader->real(key, -limit, limit);
}

PathKey key_from_json(const Json& json, const std::string& where) {
  JsonReader reader(json, where);
  PathKey key;
  key.name = reader.text("name");
  key.camera = camera_from_json(reader.member("camera"), reader.where("camera"));
  key.delay_s = reader.number("delay_s", 0.0, kLongest_s);
  key.duration_s = reader.number("duration_s", 0.0, kLongest_s);
  const std::string ease = reader.choice("ease", kEases);
  for (std::size_t i = 0; i < kEases.size(); ++i)
    if (kEases[i] == ease) key.ease = static_cast<Ease>(i);
  key.skip = reader.flag("skip");
  if (!reader.member("look").is_null()) key.look = reader.text("look");
  key.env_rotation_deg = optional_from(&reader, "env_rotation_deg", 36000.0f);
  key.exposure_ev = optional_from(&reader, "exposure_ev", 64.0f);
  reader.finish();
  return key;
}

}  // namespace

Json path_json(const CameraPath& path) {
  Json keys = Json::array();
  for (const PathKey& key : path.keys)
    keys.push_back({{"name", key.name},
                    {"camera", camera_json(key.camera)},
                    {"delay_s", key.delay_s},
                    {"duration_s", key.duration_s},
                    {"ease", kEases[static_cast<std::size_t>(key.ease)]},
                    {"skip", key.skip},
                    {"look", key.look ? Json(*key.look) : Json(nullptr)},
                    {"env_rotation_deg", optional_json(key.env_rotation_deg)},
                    {"exposure_ev", optional_json(key.exposure_ev)}});
  return {{"name", path.name}, {"closed", path.closed}, {"animation", path.animation}, {"keys", keys}};
}

CameraPath path_from_json(const Json& json, const std::string& where) {
  JsonReader reader(json, where);
  CameraPath path;
  path.name = reader.text("name");
  path.closed = reader.flag("closed");
  if (reader.has("animation")) path.animation = reader.text("animation");
  const Json& keys = reader.list("keys");
  for (std::size_t i = 0; i < keys.size(); ++i)
    path.keys.push_back(key_from_json(keys[i], reader.where("keys[" + std::to_string(i) + "]")));
  reader.finish();
  return path;
}

CameraPath load_path(const std::string& file) {
  Json json;
  try {
    json = json_from_text(read_text_file(file));
  } catch (const Json::exception& problem) {
    throw Error(file, "it is no JSON: " + json_fault(problem.what()), "export it again");
  }
  JsonReader reader(json, file + ": ");
  if (reader.count("maquette_path", 1, 1000000) > kPathFormat)
    throw Error(file, "it is of a newer version of the program", "update the program");
  CameraPath path = path_from_json(reader.member("path"), reader.where("path"));
  reader.finish();
  check_path(path, file);
  return path;
}

void save_path(const std::string& file, const CameraPath& path) {
  const std::string text = json_text(Json{{"maquette_path", kPathFormat}, {"path", path_json(path)}}, 1) + "\n";
  write_file_atomically(file, std::as_bytes(std::span(text.data(), text.size())));
}

}  // namespace maquette
