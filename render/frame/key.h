#pragma once

#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "render/frame/camera.h"
#include "render/technique/settings.h"

namespace maquette {

/// All that a result depends on, compared exactly: equal keys, equal results. Built from values in a fixed order.
class Key {
 public:
  template <typename... Parts>
  static Key of(const Parts&... parts) {
    Key key;
    (key.add(parts), ...);
    return key;
  }
  template <typename T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void add(T value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    bytes_.append(bytes, sizeof value);
  }
  void add(std::string_view text) {
    add(text.size());
    bytes_.append(text);
  }
  void add(const std::string& text) { add(std::string_view(text)); }
  void add(const char* text) { add(std::string_view(text)); }
  void add(const Key& key) { add(std::string_view(key.bytes_)); }
  void add(const glm::vec3& v) {
    for (int i = 0; i < 3; ++i) add(v[i]);
  }
  void add(const CameraView& camera) {
    for (const glm::vec3& v : {camera.eye, camera.target, camera.up}) add(v);
    for (const float f : {camera.fov_y_rad, camera.height_m, camera.near_m, camera.far_m, camera.aspect}) add(f);
    for (int i = 0; i < 4; ++i) add(camera.section[i]);
  }
  /// Values that differ from their defaults say all.
  void add(const Settings& settings) {
    add(settings.changed().size());
    for (const auto& [name, value] : settings.changed()) {
      add(name);
      add(to_text(value));
    }
  }
  template <typename T>
  void add(const std::vector<T>& values) {
    add(values.size());
    for (const auto& value : values) add(value);
  }
  void add(const std::vector<bool>& values) {
    add(values.size());
    for (const bool value : values) add(value);
  }
  bool operator==(const Key&) const = default;

 private:
  std::string bytes_;
};

}  // namespace maquette
