#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/gltf_document.h"

namespace maquette::gltf {
namespace {

constexpr std::size_t kNearestFilter = 9728, kRepeat = 10497, kClampToEdge = 33071, kMirroredRepeat = 33648;

/// Reads one material; keeps its position in the file for error messages.
class MaterialReader {
 public:
  MaterialReader(Document* document, const Scene& scene, std::size_t index)
      : document_(*document),
        scene_(scene),
        json_(element_json(*document, "materials", index)),
        name_(element("materials", index)),
        where_(at(document->path, name_)) {}

  Material read() {
    read_core();
    read_coat_and_glass();
    read_specular_and_sheen();
    read_anisotropy_and_film();
    read_extras();
    if (out_.glass && !out_.unlit) warn_of_glass();
    return out_;
  }

 private:
  const Json& member(const Json& object, const char* key) const {
    static const Json kNone = Json::object();
    const auto found = object.find(key);
    if (found == object.end()) return kNone;
    if (!found->is_object()) throw Error(where_ + "." + key, "expected an object", kInvalid);
    return *found;
  }
  const Json& extension(const char* name) const {
    static const Json kNone = Json::object();
    const Json* found = find_extension(json_, name);
    return found == nullptr ? kNone : *found;
  }
  float number(const Json& object, const char* key, float fallback) const {
    return read_number(object, key, fallback, where_);
  }
  /// A factor that the specification limits to [0, 1]: other values are clamped and reported.
  float factor(const Json& object, const char* key, float fallback) {
    const float value = number(object, key, fallback);
    if (value < 0.0f || value > 1.0f) document_.warnings.add(std::string(key) + " outside 0..1 is clamped", name_);
    return std::clamp(value, 0.0f, 1.0f);
  }
  /// One that may not be below 0.
  float amount(const Json& object, const char* key, float fallback) {
    const float value = number(object, key, fallback);
    if (value < 0.0f) document_.warnings.add(std::string(key) + " below 0 is clamped", name_);
    return std::max(value, 0.0f);
  }
  /// `most`: the limit of the specification.
  template <int N>
  glm::vec<N, float> colour(const Json& object, const char* key, const glm::vec<N, float>& fallback,
                            float most = 1.0f) {
    const auto value = read_vector<N>(object, key, fallback, where_);
    const auto clamped = glm::clamp(value, 0.0f, most);
    if (clamped != value)
      document_.warnings.add(std::string(key) + (std::isinf(most) ? " below 0 is clamped" : " outside 0..1 is clamped"),
                             name_);
    return clamped;
  }

  std::size_t texture_index(const Json& info, const std::string& where) const {
    const auto found = info.find("index");
    const std::size_t count = document_.model.textures.size();
    if (found == info.end() || !found->is_number_unsigned() || found->get<std::size_t>() >= count)
      throw Error(where + ".index", "is missing or out of range (the file has " + std::to_string(count) + " textures)",
                  kInvalid);
    return found->get<std::size_t>();
  }

  static Wrap wrap_of(const Json& sampler, const char* key) {
    const auto mode = sampler.value(key, std::size_t{0});
    return mode == kClampToEdge ? Wrap::clamp_to_edge : mode == kMirroredRepeat ? Wrap::mirrored_repeat : Wrap::repeat;
  }

  TextureRef texture(const Json& object, const char* key) {
    TextureRef ref;
    if (!object.contains(key)) return ref;
    const Json& info = member(object, key);
    const std::string where = where_ + "." + key;
    const Json& source = element_json(document_, "textures", texture_index(info, where));
    const std::optional<std::size_t> chosen = image_of_texture(source, scene_);
    if (!chosen) {
      document_.warnings.add("a texture without a readable image is left out", name_ + "." + key);
      return ref;
    }
    if (scene_.images[*chosen].width == 0) return ref;  // unreadable: the image has already been reported
    ref.image = static_cast<int>(*chosen);
    if (source.contains("sampler")) {
      const Json& sampler = element_json(document_, "samplers", source["sampler"].get<std::size_t>());
      ref.wrap_s = wrap_of(sampler, "wrapS");
      ref.wrap_t = wrap_of(sampler, "wrapT");
      ref.nearest = sampler.value("magFilter", std::size_t{0}) == kNearestFilter;
    }
    std::size_t uv_set = read_natural(info, "texCoord", 0, where);
    if (const Json* transform = find_extension(info, "KHR_texture_transform"); transform != nullptr) {
      ref.offset = read_vector<2>(*transform, "offset", ref.offset, where);
      ref.scale = read_vector<2>(*transform, "scale", ref.scale, where);
      ref.rotation_rad = read_number(*transform, "rotation", 0.0f, where);
      uv_set = read_natural(*transform, "texCoord", uv_set, where);
    }
    if (uv_set > 1) {
      document_.warnings.add("textures on UV sets above 1 are left out", name_ + "." + key);
      return {};
    }
    ref.uv_set = static_cast<int>(uv_set);
    return ref;
  }

  void read_core() {
    out_.name = read_text(json_, "name", where_);
    if (out_.name.empty())
      out_.name = "material-" + name_.substr(name_.find('[') + 1, name_.size() - name_.find('[') - 2);
    const Json& pbr = member(json_, "pbrMetallicRoughness");
    out_.base_color = colour<4>(pbr, "baseColorFactor", out_.base_color);
    out_.metallic = factor(pbr, "metallicFactor", out_.metallic);
    out_.roughness = factor(pbr, "roughnessFactor", out_.roughness);
    out_.base_color_texture = texture(pbr, "baseColorTexture");
    out_.metallic_roughness_texture = texture(pbr, "metallicRoughnessTexture");
    out_.normal_texture = texture(json_, "normalTexture");
    out_.normal_scale = number(member(json_, "normalTexture"), "scale", out_.normal_scale);
    out_.occlusion_texture = texture(json_, "occlusionTexture");
    out_.occlusion_strength = factor(member(json_, "occlusionTexture"), "strength", out_.occlusion_strength);
    const float strength = amount(extension("KHR_materials_emissive_strength"), "emissiveStrength", 1.0f);
    out_.emissive = colour<3>(json_, "emissiveFactor", out_.emissive) * strength;
    out_.emissive_texture = texture(json_, "emissiveTexture");
    const std::string mode = read_text(json_, "alphaMode", where_);
    if (mode == "MASK") {
      out_.alpha_mode = AlphaMode::mask;
    } else if (mode == "BLEND") {
      out_.alpha_mode = AlphaMode::blend;
    } else if (!mode.empty() && mode != "OPAQUE") {
      document_.warnings.add("alphaMode \"" + mode + "\" is not known and taken as OPAQUE", name_);
    }
    out_.alpha_cutoff = amount(json_, "alphaCutoff", out_.alpha_cutoff);
    out_.double_sided = read_flag(json_, "doubleSided", false, where_);
    out_.unlit = find_extension(json_, "KHR_materials_unlit") != nullptr;
  }

  void read_coat_and_glass() {
    const Json& coat = extension("KHR_materials_clearcoat");
    out_.clearcoat = factor(coat, "clearcoatFactor", out_.clearcoat);
    out_.clearcoat_roughness = factor(coat, "clearcoatRoughnessFactor", out_.clearcoat_roughness);
    out_.clearcoat_texture = texture(coat, "clearcoatTexture");
    out_.clearcoat_roughness_texture = texture(coat, "clearcoatRoughnessTexture");
    out_.clearcoat_normal_texture = texture(coat, "clearcoatNormalTexture");
    out_.clearcoat_normal_scale = number(member(coat, "clearcoatNormalTexture"), "scale", out_.clearcoat_normal_scale);
    const Json& transmission = extension("KHR_materials_transmission");
    out_.transmission = factor(transmission, "transmissionFactor", out_.transmission);
    out_.transmission_texture = texture(transmission, "transmissionTexture");
    out_.glass = may_transmit(out_);
    const Json& volume = extension("KHR_materials_volume");
    out_.thickness = amount(volume, "thicknessFactor", out_.thickness);
    out_.thickness_texture = texture(volume, "thicknessTexture");
    out_.attenuation_color = colour<3>(volume, "attenuationColor", out_.attenuation_color);
    out_.attenuation_distance = number(volume, "attenuationDistance", out_.attenuation_distance);
    if (!(out_.attenuation_distance > 0.0f)) {
      document_.warnings.add("an attenuationDistance that is not above 0 is taken as infinite", name_);
      out_.attenuation_distance = std::numeric_limits<float>::infinity();
    }
    out_.ior = number(extension("KHR_materials_ior"), "ior", out_.ior);
    if (out_.ior < 1.0f && out_.ior != 0.0f) {
      document_.warnings.add("an ior below 1 is taken as 1", name_);
      out_.ior = 1.0f;
    }
  }

  void read_specular_and_sheen() {
    const Json& specular = extension("KHR_materials_specular");
    out_.specular = factor(specular, "specularFactor", out_.specular);
    out_.specular_texture = texture(specular, "specularTexture");
    out_.specular_color =
        colour<3>(specular, "specularColorFactor", out_.specular_color, std::numeric_limits<float>::infinity());
    out_.specular_color_texture = texture(specular, "specularColorTexture");
    const Json& sheen = extension("KHR_materials_sheen");
    out_.sheen_color = colour<3>(sheen, "sheenColorFactor", out_.sheen_color);
    out_.sheen_color_texture = texture(sheen, "sheenColorTexture");
    out_.sheen_roughness = factor(sheen, "sheenRoughnessFactor", out_.sheen_roughness);
    out_.sheen_roughness_texture = texture(sheen, "sheenRoughnessTexture");
  }

  void read_anisotropy_and_film() {
    const Json& anisotropy = extension("KHR_materials_anisotropy");
    out_.anisotropy = factor(anisotropy, "anisotropyStrength", out_.anisotropy);
    out_.anisotropy_rotation_rad = number(anisotropy, "anisotropyRotation", out_.anisotropy_rotation_rad);
    out_.anisotropy_texture = texture(anisotropy, "anisotropyTexture");
    const Json& film = extension("KHR_materials_iridescence");
    out_.iridescence = factor(film, "iridescenceFactor", out_.iridescence);
    out_.iridescence_texture = texture(film, "iridescenceTexture");
    out_.iridescence_ior = number(film, "iridescenceIor", out_.iridescence_ior);
    if (out_.iridescence_ior < 1.0f) {
      document_.warnings.add("an iridescenceIor below 1 is taken as 1", name_);
      out_.iridescence_ior = 1.0f;
    }
    out_.iridescence_least_nm = amount(film, "iridescenceThicknessMinimum", out_.iridescence_least_nm);
    out_.iridescence_greatest_nm = amount(film, "iridescenceThicknessMaximum", out_.iridescence_greatest_nm);
    out_.iridescence_thickness_texture = texture(film, "iridescenceThicknessTexture");
  }

  void read_extras() {
    const Json* extras = find_extras(json_);
    if (extras == nullptr) return;
    const std::string where = where_ + ".extras.maquette";
    out_.measured = read_text(*extras, "measured", where);
    if (!out_.measured.empty() && !out_.measured.starts_with("builtin:")) {
      const std::string named = out_.measured;
      out_.measured = (std::filesystem::path(document_.path).parent_path() / named).lexically_normal().string();
      if (std::error_code code; has_scheme(named) && !std::filesystem::exists(out_.measured, code))
        throw Error(where + ".measured", name_text(named) + " is not read: only files beside the scene are");
      // What a file names is no device and no pipe: these have no end.
      if (is_written_through(out_.measured))
        throw Error(where + ".measured", out_.measured + " is no regular file", "name a table");
    }
    out_.tint_measured = read_flag(*extras, "tint_measured", false, where);
    out_.glass = read_flag(*extras, "glass", out_.glass, where);
  }

  /// What panes do not show of a material.
  void warn_of_glass() {
    constexpr float kSmooth = 0.032f;  // its GGX alpha is the least that is drawn
    std::string lobes;
    const auto add = [&](const char* name, bool is_there) {
      if (is_there) lobes += (lobes.empty() ? "" : ", ") + std::string(name);
    };
    add("clearcoat", out_.clearcoat > 0.0f);
    add("sheen", out_.sheen_color != glm::vec3(0.0f));
    add("iridescence", out_.iridescence > 0.0f);
    add("anisotropy", out_.anisotropy > 0.0f);
    if (!lobes.empty()) document_.warnings.add("the share that transmits is drawn without " + lobes, name_);
    if (out_.roughness > kSmooth)
      document_.warnings.add("the share that transmits is drawn smooth, except by full transport of mode reference",
                             name_);
  }

  Document& document_;
  const Scene& scene_;
  const Json& json_;
  std::string name_;
  std::string where_;
  Material out_;
};

/// Codes that glTF does not know are read as repeat and linear.
void check_samplers(Document* document) {
  const auto samplers = document->root.find("samplers");
  if (samplers == document->root.end()) return;
  for (std::size_t i = 0; i < samplers->size(); ++i) {
    const auto check = [&](const char* key, std::initializer_list<std::size_t> known, const char* taken) {
      const auto found = (*samplers)[i].find(key);
      if (found == (*samplers)[i].end()) return;
      const bool valid =
          found->is_number_unsigned() && std::count(known.begin(), known.end(), found->get<std::size_t>()) > 0;
      if (!valid)
        document->warnings.add(std::string(key) + " is no code of glTF and taken as " + taken, element("samplers", i));
    };
    check("wrapS", {kRepeat, kClampToEdge, kMirroredRepeat}, "repeat");
    check("wrapT", {kRepeat, kClampToEdge, kMirroredRepeat}, "repeat");
    check("magFilter", {kNearestFilter, 9729}, "linear");
    check("minFilter", {kNearestFilter, 9729, 9984, 9985, 9986, 9987}, "linear");
  }
}

}  // namespace

void import_materials(Document* document, Scene* scene) {
  import_images(document, scene);
  check_samplers(document);
  if (const auto found = document->root.find("materials"); found != document->root.end())
    for (std::size_t i = 0; i < found->size(); ++i)
      scene->materials.push_back(MaterialReader(document, *scene, i).read());
  if (const Json* variants = find_extension(document->root, "KHR_materials_variants"); variants != nullptr)
    for (const Json& variant : (*variants)["variants"]) scene->variants.push_back(variant["name"].get<std::string>());
}

}  // namespace maquette::gltf
