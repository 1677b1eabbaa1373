#include <cmath>

#include "scenes/error.h"
#include "scenes/gltf_document.h"

namespace maquette::gltf {
namespace {

float checked_number(const Json& value, const std::string& where) {
  const bool usable = value.is_number() && std::isfinite(static_cast<float>(value.get<double>()));
  if (!usable) throw Error(where, "expected a number", kInvalid);
  return static_cast<float>(value.get<double>());
}

}  // namespace

const Json* find_extension(const Json& element, const char* name) {
  const auto extensions = element.find("extensions");
  if (extensions == element.end() || !extensions->is_object()) return nullptr;
  const auto found = extensions->find(name);
  return found != extensions->end() && found->is_object() ? &*found : nullptr;
}

const Json* find_extras(const Json& element) {
  const auto extras = element.find("extras");
  if (extras == element.end() || !extras->is_object()) return nullptr;
  const auto found = extras->find("maquette");
  return found != extras->end() && found->is_object() ? &*found : nullptr;
}

const Json& element_json(const Document& document, const char* array, std::size_t index) {
  return document.root[array][index];
}

float read_number(const Json& object, const char* key, float fallback, const std::string& where) {
  const auto found = object.find(key);
  return found == object.end() ? fallback : checked_number(*found, where + "." + key);
}

std::size_t read_natural(const Json& object, const char* key, std::size_t fallback, const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end()) return fallback;
  if (!found->is_number_unsigned()) throw Error(where + "." + key, "expected a whole number", kInvalid);
  return found->get<std::size_t>();
}

bool read_flag(const Json& object, const char* key, bool fallback, const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end()) return fallback;
  if (!found->is_boolean()) throw Error(where + "." + key, "expected true or false", kInvalid);
  return found->get<bool>();
}

std::string read_text(const Json& object, const char* key, const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end()) return {};
  if (!found->is_string()) throw Error(where + "." + key, "expected text", kInvalid);
  return found->get<std::string>();
}

template <int N>
glm::vec<N, float> read_vector(const Json& object, const char* key, const glm::vec<N, float>& fallback,
                               const std::string& where) {
  const auto found = object.find(key);
  if (found == object.end()) return fallback;
  if (!found->is_array() || found->size() != N)
    throw Error(where + "." + key, "expected " + std::to_string(N) + " numbers", kInvalid);
  glm::vec<N, float> out;
  for (int i = 0; i < N; ++i) out[i] = checked_number((*found)[static_cast<std::size_t>(i)], where + "." + key);
  return out;
}
template glm::vec2 read_vector<2>(const Json&, const char*, const glm::vec2&, const std::string&);
template glm::vec3 read_vector<3>(const Json&, const char*, const glm::vec3&, const std::string&);
template glm::vec4 read_vector<4>(const Json&, const char*, const glm::vec4&, const std::string&);

}  // namespace maquette::gltf
