#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "scenes/error.h"
#include "scenes/gltf_file.h"
#include "scenes/json_fault.h"

namespace maquette::gltf {
namespace {

/// Largest nesting depth, so that the recursion of the parsers stays bounded; glTF files nest about ten deep.
constexpr int kMaxNesting = 200;
/// Largest integer that a double represents exactly: larger counts and offsets are invalid.
constexpr std::uint64_t kMaxInteger = std::uint64_t{1} << 53;
/// Codes and identifiers are kept as int by tinygltf, as 32 bits by Draco.
constexpr std::uint64_t kMaxCode = std::numeric_limits<std::int32_t>::max();

constexpr std::array<std::string_view, 19> kReadExtensions = {
    "KHR_draco_mesh_compression", "KHR_mesh_quantization",
    "KHR_texture_transform",      "KHR_lights_punctual",
    "KHR_materials_clearcoat",    "KHR_materials_transmission",
    "KHR_materials_ior",          "KHR_materials_specular",
    "KHR_materials_sheen",        "KHR_materials_emissive_strength",
    "KHR_materials_variants",     "KHR_materials_unlit",
    "KHR_materials_volume",       "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",    "EXT_texture_webp",
    "KHR_materials_anisotropy",   "KHR_materials_iridescence",
    "KHR_node_visibility",
};

enum class Kind { index, natural, code, stride, number, text, boolean, object, array };

/// One member of the file. In `path`, `[]` steps into every element of an array and `{}` into every value of an object.
struct Rule {
  const char* path;
  Kind kind;
  bool required = false;
  const char* target = nullptr;  ///< for an index: the top-level array it points into
  std::size_t length = 0;        ///< for an array of numbers: its length
};

constexpr Rule kRules[] = {
    {"asset", Kind::object, true},
    {"asset.version", Kind::text, true},
    {"asset.minVersion", Kind::text},
    {"extensionsUsed[]", Kind::text},
    {"extensionsRequired[]", Kind::text},
    {"extensions", Kind::object},
    {"buffers[].byteLength", Kind::natural, true},
    {"buffers[].uri", Kind::text},
    {"bufferViews[].buffer", Kind::index, true, "buffers"},
    {"bufferViews[].byteOffset", Kind::natural},
    {"bufferViews[].byteLength", Kind::natural, true},
    {"bufferViews[].byteStride", Kind::stride},
    {"bufferViews[].extensions.EXT_meshopt_compression", Kind::object},
    {"bufferViews[].extensions.EXT_meshopt_compression.buffer", Kind::index, true, "buffers"},
    {"bufferViews[].extensions.EXT_meshopt_compression.byteOffset", Kind::natural},
    {"bufferViews[].extensions.EXT_meshopt_compression.byteLength", Kind::natural, true},
    {"bufferViews[].extensions.EXT_meshopt_compression.byteStride", Kind::code, true},
    {"bufferViews[].extensions.EXT_meshopt_compression.count", Kind::code, true},
    {"bufferViews[].extensions.EXT_meshopt_compression.mode", Kind::text, true},
    {"bufferViews[].extensions.EXT_meshopt_compression.filter", Kind::text},
    {"accessors[].bufferView", Kind::index, false, "bufferViews"},
    {"accessors[].byteOffset", Kind::natural},
    {"accessors[].componentType", Kind::code, true},
    {"accessors[].count", Kind::natural, true},
    {"accessors[].type", Kind::text, true},
    {"accessors[].normalized", Kind::boolean},
    {"accessors[].sparse", Kind::object},
    {"accessors[].sparse.count", Kind::natural, true},
    {"accessors[].sparse.indices", Kind::object, true},
    {"accessors[].sparse.indices.bufferView", Kind::index, true, "bufferViews"},
    {"accessors[].sparse.indices.byteOffset", Kind::natural},
    {"accessors[].sparse.indices.componentType", Kind::code, true},
    {"accessors[].sparse.values", Kind::object, true},
    {"accessors[].sparse.values.bufferView", Kind::index, true, "bufferViews"},
    {"accessors[].sparse.values.byteOffset", Kind::natural},
    {"images[].name", Kind::text},
    {"images[].uri", Kind::text},
    {"images[].bufferView", Kind::index, false, "bufferViews"},
    {"samplers[].magFilter", Kind::code},
    {"samplers[].wrapS", Kind::code},
    {"samplers[].wrapT", Kind::code},
    {"textures[].source", Kind::index, false, "images"},
    {"textures[].sampler", Kind::index, false, "samplers"},
    {"textures[].extensions", Kind::object},
    {"textures[].extensions.EXT_texture_webp.source", Kind::index, false, "images"},
    {"materials[].name", Kind::text},
    {"materials[].extensions", Kind::object},
    {"meshes[].name", Kind::text},
    {"meshes[].primitives", Kind::array, true},
    {"meshes[].primitives[].attributes", Kind::object, true},
    {"meshes[].primitives[].attributes{}", Kind::index, true, "accessors"},
    {"meshes[].primitives[].indices", Kind::index, false, "accessors"},
    {"meshes[].primitives[].material", Kind::index, false, "materials"},
    {"meshes[].primitives[].mode", Kind::code},
    {"meshes[].weights[]", Kind::number, true},
    {"meshes[].primitives[].targets", Kind::array},
    {"meshes[].primitives[].targets[]", Kind::object},
    {"meshes[].primitives[].targets[].POSITION", Kind::index, false, "accessors"},
    {"meshes[].primitives[].targets[].NORMAL", Kind::index, false, "accessors"},
    {"meshes[].primitives[].targets[].TANGENT", Kind::index, false, "accessors"},
    {"meshes[].primitives[].targets[].TEXCOORD_0", Kind::index, false, "accessors"},
    {"meshes[].primitives[].targets[].TEXCOORD_1", Kind::index, false, "accessors"},
    {"meshes[].primitives[].targets[].COLOR_0", Kind::index, false, "accessors"},
    {"meshes[].primitives[].extensions", Kind::object},
    {"meshes[].primitives[].extensions.KHR_draco_mesh_compression.bufferView", Kind::index, true, "bufferViews"},
    {"meshes[].primitives[].extensions.KHR_draco_mesh_compression.attributes", Kind::object, true},
    {"meshes[].primitives[].extensions.KHR_draco_mesh_compression.attributes{}", Kind::code, true},
    {"meshes[].primitives[].extensions.KHR_materials_variants.mappings", Kind::array, true},
    {"meshes[].primitives[].extensions.KHR_materials_variants.mappings[].material", Kind::index, true, "materials"},
    {"meshes[].primitives[].extensions.KHR_materials_variants.mappings[].variants[]", Kind::natural, true},
    {"nodes[].name", Kind::text},
    {"nodes[].mesh", Kind::index, false, "meshes"},
    {"nodes[].skin", Kind::index, false, "skins"},
    {"nodes[].weights[]", Kind::number, true},
    {"nodes[].extensions", Kind::object},
    {"nodes[].extensions.KHR_node_visibility", Kind::object},
    {"nodes[].extensions.KHR_node_visibility.visible", Kind::boolean},
    {"nodes[].extensions.EXT_mesh_gpu_instancing", Kind::object},
    {"nodes[].extensions.EXT_mesh_gpu_instancing.attributes", Kind::object, true},
    {"nodes[].extensions.EXT_mesh_gpu_instancing.attributes{}", Kind::index, true, "accessors"},
    {"skins[].joints", Kind::array, true},
    {"skins[].joints[]", Kind::index, true, "nodes"},
    {"skins[].inverseBindMatrices", Kind::index, false, "accessors"},
    {"nodes[].children[]", Kind::index, true, "nodes"},
    {"nodes[].matrix", Kind::array, false, nullptr, 16},
    {"nodes[].translation", Kind::array, false, nullptr, 3},
    {"nodes[].rotation", Kind::array, false, nullptr, 4},
    {"nodes[].scale", Kind::array, false, nullptr, 3},
    {"scenes[].nodes[]", Kind::index, true, "nodes"},
    {"scene", Kind::index, false, "scenes"},
    {"extensions.KHR_materials_variants.variants", Kind::array, true},
    {"extensions.KHR_materials_variants.variants[].name", Kind::text, true},
};

/// Applies the rules to one document; `trail_` is the current position, formatted only for an error.
class Checker {
 public:
  Checker(const std::string& path, const Json& root) : path_(path), root_(root) {}

  void run() {
    if (!root_.is_object()) throw Error(path_, "is not a glTF file: its JSON is not an object");
    for (const Rule& rule : kRules) visit(root_, rule.path, rule);
  }

 private:
  struct Step {
    std::string_view name;
    std::ptrdiff_t index;
  };

  [[noreturn]] void fail(const std::string& what) const {
    std::string where;
    for (const Step& step : trail_) {
      if (!where.empty() && !step.name.empty()) where.push_back('.');
      where.append(step.name);
      if (step.index >= 0) where.append("[").append(std::to_string(step.index)).append("]");
    }
    throw Error(at(path_, where), what, kInvalid);
  }

  void visit(const Json& parent, std::string_view rest, const Rule& rule) {
    const std::size_t dot = rest.find('.');
    std::string_view name = rest.substr(0, dot);
    rest = dot == std::string_view::npos ? std::string_view{} : rest.substr(dot + 1);
    const bool each_element = name.ends_with("[]");
    const bool each_value = name.ends_with("{}");
    if (each_element || each_value) name.remove_suffix(2);
    if (!parent.is_object()) fail("expected an object");
    const auto member = parent.find(name);
    trail_.push_back({name, -1});
    if (member == parent.end()) {
      if (rest.empty() && rule.required && !each_element && !each_value) fail("is missing");
    } else if (each_element) {
      visit_elements(*member, rest, rule);
    } else if (each_value) {
      visit_values(*member, rest, rule);
    } else if (rest.empty()) {
      check(*member, rule);
    } else {
      visit(*member, rest, rule);
    }
    trail_.pop_back();
  }

  void visit_elements(const Json& array, std::string_view rest, const Rule& rule) {
    if (!array.is_array()) fail("expected an array");
    for (std::size_t i = 0; i < array.size(); ++i) {
      trail_.back().index = static_cast<std::ptrdiff_t>(i);
      rest.empty() ? check(array[i], rule) : visit(array[i], rest, rule);
    }
  }

  void visit_values(const Json& object, std::string_view rest, const Rule& rule) {
    if (!object.is_object()) fail("expected an object");
    for (auto it = object.begin(); it != object.end(); ++it) {
      trail_.push_back({it.key(), -1});
      rest.empty() ? check(it.value(), rule) : visit(it.value(), rest, rule);
      trail_.pop_back();
    }
  }

  void check(const Json& value, const Rule& rule) const {
    switch (rule.kind) {
      case Kind::index:
        check_index(value, rule.target);
        break;
      case Kind::natural:
        if (!value.is_number_unsigned() || value.get<std::uint64_t>() > kMaxInteger)
          fail("expected a whole number, found " + brief(value));
        break;
      case Kind::code:
        if (!value.is_number_unsigned() || value.get<std::uint64_t>() > kMaxCode)
          fail("expected a whole number, found " + brief(value));
        break;
      case Kind::stride:
        check_stride(value);
        break;
      case Kind::number:
        if (!value.is_number()) fail("expected a number, found " + brief(value));
        break;
      case Kind::text:
        if (!value.is_string()) fail("expected text, found " + brief(value));
        break;
      case Kind::boolean:
        if (!value.is_boolean()) fail("expected true or false, found " + brief(value));
        break;
      case Kind::object:
        if (!value.is_object()) fail("expected an object, found " + brief(value));
        break;
      case Kind::array:
        check_array(value, rule.length);
        break;
    }
  }

  void check_index(const Json& value, const char* target) const {
    const auto found = root_.find(target);
    const std::size_t count = found != root_.end() && found->is_array() ? found->size() : 0;
    if (!value.is_number_unsigned() || value.get<std::uint64_t>() >= count)
      fail(brief(value) + " is out of range (the file has " + std::to_string(count) + " " + target + ")");
  }

  void check_stride(const Json& value) const {
    const std::uint64_t stride = value.is_number_unsigned() ? value.get<std::uint64_t>() : 1;
    if (stride % 4 != 0 || stride > 252) fail(brief(value) + " is not a multiple of 4 up to 252");
  }

  void check_array(const Json& value, std::size_t length) const {
    if (!value.is_array()) fail("expected an array, found " + brief(value));
    if (length == 0) return;
    const bool numbers = std::all_of(value.begin(), value.end(), [](const Json& v) { return v.is_number(); });
    if (value.size() != length || !numbers)
      fail("expected " + std::to_string(length) + " numbers, found " + brief(value));
  }

  static std::string brief(const Json& value) {
    if (value.is_array()) return "an array of " + std::to_string(value.size());
    if (value.is_object()) return "an object";
    if (value.is_string()) return name_text(value.get_ref<const std::string&>());
    return value.dump();
  }

  const std::string& path_;
  const Json& root_;
  std::vector<Step> trail_;
};

/// Gives integers the type of integers however they are spelled: JSON has numbers only, so that 1.0, 1e0 and -0 are 1
/// and 0. Other numbers stay.
void canonicalise(Json* value) {
  if (value->is_structured()) {
    for (Json& item : *value) canonicalise(&item);
  } else if (value->is_number_float()) {
    const auto number = value->get<double>();
    if (number != std::floor(number) || std::abs(number) > static_cast<double>(kMaxInteger)) return;
    *value = static_cast<std::int64_t>(number);
    canonicalise(value);
  } else if (value->is_number_integer() && !value->is_number_unsigned() && value->get<std::int64_t>() >= 0) {
    *value = static_cast<std::uint64_t>(value->get<std::int64_t>());
  }
}

/// Collects the extensions used anywhere, also undeclared ones; `extras` are skipped, because they belong to the
/// author.
void collect_extensions(const Json& value, std::set<std::string>* names) {
  if (value.is_array()) {
    for (const Json& item : value) collect_extensions(item, names);
  } else if (value.is_object()) {
    for (auto it = value.begin(); it != value.end(); ++it) {
      if (it.key() == "extras" || !it.value().is_structured()) continue;
      if (it.key() == "extensions" && it.value().is_object())
        for (auto extension = it.value().begin(); extension != it.value().end(); ++extension)
          names->insert(extension.key());
      collect_extensions(it.value(), names);
    }
  }
}

bool is_read(const std::string& extension) {
  return std::find(kReadExtensions.begin(), kReadExtensions.end(), extension) != kReadExtensions.end();
}

/// Numbers beyond double, as in 1e309, become its largest: they are out of range wherever they stand, and what they say
/// is judged there. The parser refuses a file that has one.
std::string within_double(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t begin = i;
    if (text[i] == '"') {
      for (++i; i < text.size() && text[i] != '"'; ++i) i += text[i] == '\\' ? 1 : 0;
      i = std::min(i + 1, text.size());
    } else if (std::isdigit(static_cast<unsigned char>(text[i]))) {
      i = std::min(text.find_first_not_of("0123456789.eE+-", i), text.size());
      if (std::isinf(std::strtod(std::string(text.substr(begin, i - begin)).c_str(), nullptr))) {
        out += "1.7976931348623157e308";
        continue;
      }
    } else {
      ++i;
    }
    out += text.substr(begin, i - begin);
  }
  return out;
}

/// Limits the elements that take most memory for their text (nodes), and those that shading numbers in 16 bits
/// (materials).
void check_counts(const std::string& path, const Json& root) {
  constexpr std::pair<const char*, std::size_t> kMost[] = {{"nodes", 1'000'000}, {"materials", 65'535}};
  if (!root.is_object()) return;
  for (const auto& [name, most] : kMost)
    if (const auto found = root.find(name); found != root.end() && found->size() > most)
      throw Error(
          path,
          "has " + std::to_string(found->size()) + " " + name + ", at most " + std::to_string(most) + " are possible",
          "join some of them and export it again");
}

Json parse_numbers_of_any_size(std::string_view text) {
  constexpr int kOverflow = 406;
  try {
    return Json::parse(text);
  } catch (const Json::out_of_range& e) {
    if (e.id != kOverflow) throw;
    return Json::parse(within_double(text));
  }
}

}  // namespace

Json parse_checked(const std::string& path, std::string_view text) {
  if (is_nested_deeper(text, kMaxNesting))
    throw Error(path, "JSON is nested deeper than " + std::to_string(kMaxNesting), kInvalid);
  if (has_too_many_values(text))
    throw Error(path, "its JSON has more than 20 million values or 2 million objects",
                "numbers belong into a buffer, small parts into one mesh");
  Json root;
  try {
    root = parse_numbers_of_any_size(text);
  } catch (const Json::exception& e) {
    throw Error(path, "is not valid JSON: " + json_fault(e.what()), "the file is damaged or not glTF");
  }
  canonicalise(&root);
  check_counts(path, root);
  Checker(path, root).run();
  const std::string version = root["asset"]["version"].get<std::string>();
  const std::string required = root["asset"].value("minVersion", std::string("2.0"));
  if (!version.starts_with("2.") || required != "2.0")
    throw Error(path, "is glTF " + (version.starts_with("2.") ? required : version) + ", expected 2.0",
                "export as glTF 2.0");
  return root;
}

void check_extensions(const std::string& path, const Json& root, Warnings* warnings) {
  const auto required = root.find("extensionsRequired");
  if (required != root.end()) {
    for (const Json& name : *required)
      if (!is_read(name.get<std::string>()))
        throw Error(path, "requires the extension " + name.get<std::string>() + ", which is not supported",
                    "export the file without it");
  }
  std::set<std::string> names;
  if (const auto used = root.find("extensionsUsed"); used != root.end())
    for (const Json& name : *used) names.insert(name.get<std::string>());
  collect_extensions(root, &names);
  for (const std::string& name : names)
    if (!is_read(name)) warnings->add("the extension " + name + " is not supported and is ignored");
}

}  // namespace maquette::gltf
