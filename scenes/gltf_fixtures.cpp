#include <cmath>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <optional>
#include <set>

#include "scenes/gltf_document.h"

namespace maquette::gltf {
namespace {

constexpr const char* kLights = "KHR_lights_punctual";
constexpr float kDefaultNear_m = 0.01f;
/// Angles are written in decimals: half a right angle may come out a little above.
constexpr float kAngleTolerance = 1e-5f;

/// A camera or lamp: members of the wrong type count as missing. Collects what was wrong for one warning.
class FixtureReader {
 public:
  explicit FixtureReader(const Json& json) : json_(json) {}

  FixtureReader member(const char* key) const {
    static const Json kNone = Json::object();
    const auto found = json_.is_object() ? json_.find(key) : json_.end();
    return FixtureReader(json_.is_object() && found != json_.end() && found->is_object() ? *found : kNone);
  }
  bool has_object(const char* key) const { return json_.is_object() && json_.contains(key) && json_[key].is_object(); }

  std::optional<float> number(const char* key, std::vector<std::string>* notes) const {
    if (!json_.is_object() || !json_.contains(key)) return std::nullopt;
    const Json& value = json_[key];
    const float number = value.is_number() ? static_cast<float>(value.get<double>()) : std::nanf("");
    if (std::isfinite(number)) return number;
    notes->push_back(std::string(key) + " is not a number and is ignored");
    return std::nullopt;
  }

  std::string text(const char* key, std::vector<std::string>* notes) const {
    if (!json_.is_object() || !json_.contains(key)) return {};
    if (json_[key].is_string()) return json_[key].get<std::string>();
    notes->push_back(std::string(key) + " is not text and is ignored");
    return {};
  }

  std::optional<glm::vec3> color(const char* key, std::vector<std::string>* notes) const {
    if (!json_.is_object() || !json_.contains(key)) return std::nullopt;
    const Json& value = json_[key];
    glm::vec3 out(0.0f);
    bool usable = value.is_array() && value.size() == 3;
    for (int c = 0; usable && c < 3; ++c) {
      const Json& item = value[static_cast<std::size_t>(c)];
      out[c] = item.is_number() ? static_cast<float>(item.get<double>()) : std::nanf("");
      usable = std::isfinite(out[c]);
    }
    if (usable) return out;
    notes->push_back(std::string(key) + " is not three numbers and is ignored");
    return std::nullopt;
  }

 private:
  const Json& json_;
};

using Notes = std::vector<std::string>;

void report(Document* document, const Notes& notes, const std::string& where) {
  std::string line;
  for (const std::string& note : notes) line += (line.empty() ? "" : "; ") + note;
  if (!line.empty()) document->warnings.add(line, where);
}

/// Near and far plane of either kind.
void read_planes(const FixtureReader& lens, Camera* camera, Notes* notes) {
  camera->near_m = lens.number("znear", notes).value_or(0.0f);
  camera->far_m = std::numeric_limits<float>::infinity();
  const std::optional<float> far_m = lens.number("zfar", notes);
  const bool from_eye = camera->height_m > 0.0f && camera->near_m == 0.0f;  // which an orthographic camera may show
  if (!(camera->near_m > 0.0f) && !from_eye) {
    camera->near_m = far_m && *far_m > 0.0f ? std::min(kDefaultNear_m, *far_m * 1e-3f) : kDefaultNear_m;
    notes->push_back("znear is not above 0: 1 cm is used, or a thousandth of zfar");
  }
  if (far_m && *far_m > camera->near_m) camera->far_m = *far_m;
  if (far_m && !(*far_m > camera->near_m)) notes->push_back("zfar is not beyond znear and is ignored");
}

/// xmag and ymag are half of what is seen. Below 0 they would mirror the picture.
std::optional<Camera> read_orthographic(const FixtureReader& lens, Notes* notes) {
  Camera camera;
  const float x = std::abs(lens.number("xmag", notes).value_or(0.0f)),
              y = std::abs(lens.number("ymag", notes).value_or(0.0f));
  if (!(x > 0.0f && y > 0.0f)) {
    *notes = {"the camera is left out: xmag or ymag is 0 or missing"};
    return std::nullopt;
  }
  if (*lens.number("xmag", notes) < 0.0f || *lens.number("ymag", notes) < 0.0f)
    notes->push_back("xmag or ymag is below 0: the picture is not mirrored");
  camera.height_m = 2.0f * y;
  camera.aspect = x / y;
  read_planes(lens, &camera, notes);
  return camera;
}

std::optional<Camera> read_camera(const FixtureReader& json, Notes* notes) {
  const std::string type = json.text("type", notes);
  if ((type != "perspective" && type != "orthographic") || !json.has_object(type.c_str())) {
    *notes = {"the camera is left out: it is neither perspective nor orthographic"};
    return std::nullopt;
  }
  const FixtureReader lens = json.member(type.c_str());
  if (type == "orthographic") {
    std::optional<Camera> camera = read_orthographic(lens, notes);
    if (camera) camera->name = json.text("name", notes);
    return camera;
  }
  Camera camera;
  camera.name = json.text("name", notes);
  camera.fov_y_rad = lens.number("yfov", notes).value_or(0.0f);
  if (!(camera.fov_y_rad > 0.0f && camera.fov_y_rad < glm::pi<float>())) {
    *notes = {"the camera is left out: yfov is not between 0 and pi"};
    return std::nullopt;
  }
  read_planes(lens, &camera, notes);
  const std::optional<float> aspect = lens.number("aspectRatio", notes);
  if (aspect && *aspect > 0.0f) camera.aspect = *aspect;
  if (aspect && !(*aspect > 0.0f)) notes->push_back("aspectRatio is not above 0 and is ignored");
  return camera;
}

/// Cone of a spot; false when it is empty.
bool read_cone(const FixtureReader& spot, PunctualLight* light, Notes* notes) {
  light->inner_cone_rad = spot.number("innerConeAngle", notes).value_or(light->inner_cone_rad);
  light->outer_cone_rad = spot.number("outerConeAngle", notes).value_or(light->outer_cone_rad);
  if (!(light->outer_cone_rad > 0.0f)) {
    *notes = {"the spot is left out: outerConeAngle is not above 0"};
    return false;
  }
  if (light->outer_cone_rad > glm::half_pi<float>()) {
    if (light->outer_cone_rad > glm::half_pi<float>() + kAngleTolerance)
      notes->push_back("outerConeAngle beyond pi/2 is clamped");
    light->outer_cone_rad = glm::half_pi<float>();
  }
  if (light->inner_cone_rad < 0.0f) {
    notes->push_back("innerConeAngle below 0 is clamped");
    light->inner_cone_rad = 0.0f;
  }
  if (light->inner_cone_rad >= light->outer_cone_rad) {
    notes->push_back("innerConeAngle is not below outerConeAngle: the cone has a sharp edge");
    light->inner_cone_rad = std::nextafter(light->outer_cone_rad, 0.0f);
  }
  return true;
}

std::optional<PunctualLight> read_light(const FixtureReader& json, Notes* notes) {
  PunctualLight light;
  const std::string type = json.text("type", notes);
  if (type == "directional") {
    light.kind = PunctualLight::Kind::directional;
  } else if (type == "spot") {
    light.kind = PunctualLight::Kind::spot;
  } else if (type != "point") {
    *notes = {"the lamp is left out: its type " + name_text(type) + " is not directional, point or spot"};
    return std::nullopt;
  }
  light.name = json.text("name", notes);
  light.color = json.color("color", notes).value_or(light.color);
  light.intensity = json.number("intensity", notes).value_or(light.intensity);
  light.range_m = json.number("range", notes).value_or(light.range_m);
  if (glm::any(glm::lessThan(light.color, glm::vec3(0.0f)))) notes->push_back("color below 0 is clamped");
  if (light.intensity < 0.0f) notes->push_back("intensity below 0 is clamped");
  if (light.range_m < 0.0f) notes->push_back("range below 0 is taken as infinite");
  light.color = glm::max(light.color, glm::vec3(0.0f));
  light.intensity = std::max(light.intensity, 0.0f);
  light.range_m = std::max(light.range_m, 0.0f);
  if (light.kind == PunctualLight::Kind::spot && !read_cone(json.member("spot"), &light, notes)) return std::nullopt;
  return light;
}

/// Reads every element of `array` by `read`. Indices in `out`, -1 for what is left out.
template <typename T, typename Read>
std::vector<int> import_all(Document* document, const Json& array, const std::string& name, const Read& read,
                            std::vector<T>* out) {
  std::vector<int> map;
  if (!array.is_array()) {
    document->warnings.add("is not an array and is ignored", name);
    return map;
  }
  for (std::size_t i = 0; i < array.size(); ++i) {
    Notes notes;
    const std::optional<T> item = read(FixtureReader(array[i]), &notes);
    report(document, notes, name + "[" + std::to_string(i) + "]");
    map.push_back(item ? static_cast<int>(out->size()) : -1);
    if (item) out->push_back(*item);
  }
  return map;
}

/// `map[value]`, or -1 and a warning when it is no index of `map`.
int look_up(Document* document, const Json& value, const std::vector<int>& map, const std::string& kind,
            std::size_t node) {
  if (value.is_number_unsigned() && value.get<std::size_t>() < map.size()) return map[value.get<std::size_t>()];
  document->warnings.add("names a " + kind + " that is not there: it is left out", element("nodes", node));
  return -1;
}

}  // namespace

Fixtures import_fixtures(Document* document, Scene* scene) {
  Fixtures out;
  if (const auto found = document->root.find("cameras"); found != document->root.end())
    out.cameras = import_all(document, *found, "cameras", read_camera, &scene->cameras);
  const Json* extension = find_extension(document->root, kLights);
  if (extension != nullptr && extension->contains("lights"))
    out.lights =
        import_all(document, (*extension)["lights"], std::string(kLights) + ".lights", read_light, &scene->lights);
  return out;
}

int camera_of_node(Document* document, const Fixtures& fixtures, std::size_t node) {
  const Json& json = element_json(*document, "nodes", node);
  return json.contains("camera") ? look_up(document, json["camera"], fixtures.cameras, "camera", node) : -1;
}

int light_of_node(Document* document, const Fixtures& fixtures, std::size_t node) {
  const Json* extension = find_extension(element_json(*document, "nodes", node), kLights);
  if (extension == nullptr) return -1;
  const auto found = extension->find("light");
  return look_up(document, found == extension->end() ? Json() : *found, fixtures.lights, "lamp", node);
}

void place_cameras(Document* document, Scene* scene) {
  const std::vector<glm::mat4> world = compute_world_transforms(*scene);
  std::set<int> taken;
  for (std::size_t i = 0; i < scene->nodes.size(); ++i) {
    Node& node = scene->nodes[i];
    if (node.camera < 0) continue;
    const glm::vec3 forward(world[i][2]), up(world[i][1]);
    const float area = glm::length(glm::cross(glm::normalize(forward), glm::normalize(up)));
    if (!(area > 0.0f)) {
      document->warnings.add("its camera is left out: the node's scale is 0", name_node(node.name, i));
      node.camera = -1;
      continue;
    }
    if (!taken.insert(node.camera).second) {
      Camera copy = scene->cameras[static_cast<std::size_t>(node.camera)];
      copy.name = node.name;
      node.camera = static_cast<int>(scene->cameras.size());
      scene->cameras.push_back(std::move(copy));
      taken.insert(node.camera);
    }
    Camera& camera = scene->cameras[static_cast<std::size_t>(node.camera)];
    if (camera.name.empty()) camera.name = node.name;
  }
  for (std::size_t i = 0; i < scene->cameras.size(); ++i)
    if (scene->cameras[i].name.empty()) scene->cameras[i].name = "camera-" + std::to_string(i);
}

}  // namespace maquette::gltf
