#include "scenes/gltf_materials_save.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <glm/gtc/type_ptr.hpp>
#include <map>
#include <nlohmann/json.hpp>

namespace maquette {
namespace {

using Json = nlohmann::json;

template <typename Vector>
Json to_json(const Vector& v) {
  Json out = Json::array();
  for (int i = 0; i < v.length(); ++i) out.push_back(v[i]);
  return out;
}

int wrap_mode(Wrap wrap) { return wrap == Wrap::clamp_to_edge ? 33071 : wrap == Wrap::mirrored_repeat ? 33648 : 10497; }

class MaterialWriter {
 public:
  MaterialWriter(const std::string& path, Json* root, std::set<std::string>* extensions)
      : path_(path), root_(*root), extensions_(*extensions) {}

  Json write(const Material& material) {
    Json out = {{"name", material.name}};
    write_core(material, &out);
    write_layers(material, &out);
    write_anisotropy_and_film(material, &out);
    write_extras(material, &out);
    return out;
  }

 private:
  int sampler(const TextureRef& ref) {
    const std::array<int, 3> key = {wrap_mode(ref.wrap_s), wrap_mode(ref.wrap_t), ref.nearest ? 9728 : 9729};
    const auto [found, is_new] = samplers_.try_emplace(key, static_cast<int>(samplers_.size()));
    if (is_new) root_["samplers"].push_back({{"wrapS", key[0]}, {"wrapT", key[1]}, {"magFilter", key[2]}});
    return found->second;
  }

  int texture(const TextureRef& ref) {
    const std::array<int, 2> key = {ref.image, sampler(ref)};
    const auto [found, is_new] = textures_.try_emplace(key, static_cast<int>(textures_.size()));
    if (is_new) root_["textures"].push_back({{"source", key[0]}, {"sampler", key[1]}});
    return found->second;
  }

  void put_texture(Json* object, const char* key, const TextureRef& ref) {
    if (!ref) return;
    Json info = {{"index", texture(ref)}};
    if (ref.uv_set != 0) info["texCoord"] = ref.uv_set;
    if (ref.offset != glm::vec2(0.0f) || ref.scale != glm::vec2(1.0f) || ref.rotation_rad != 0.0f) {
      extensions_.insert("KHR_texture_transform");
      info["extensions"]["KHR_texture_transform"] = {
          {"offset", to_json(ref.offset)}, {"scale", to_json(ref.scale)}, {"rotation", ref.rotation_rad}};
    }
    (*object)[key] = std::move(info);
  }

  void put_number(Json* object, const char* key, float value, float standard) {
    if (value != standard) (*object)[key] = value;
  }

  void put_extension(Json* out, const char* name, Json content) {
    if (content.empty()) return;
    extensions_.insert(name);
    (*out)["extensions"][name] = std::move(content);
  }

  void write_core(const Material& material, Json* out) {
    Json pbr = Json::object();
    if (material.base_color != glm::vec4(1.0f)) pbr["baseColorFactor"] = to_json(material.base_color);
    put_number(&pbr, "metallicFactor", material.metallic, 1.0f);
    put_number(&pbr, "roughnessFactor", material.roughness, 1.0f);
    put_texture(&pbr, "baseColorTexture", material.base_color_texture);
    put_texture(&pbr, "metallicRoughnessTexture", material.metallic_roughness_texture);
    if (!pbr.empty()) (*out)["pbrMetallicRoughness"] = std::move(pbr);
    put_texture(out, "normalTexture", material.normal_texture);
    if (material.normal_texture) put_number(&(*out)["normalTexture"], "scale", material.normal_scale, 1.0f);
    put_texture(out, "occlusionTexture", material.occlusion_texture);
    if (material.occlusion_texture)
      put_number(&(*out)["occlusionTexture"], "strength", material.occlusion_strength, 1.0f);
    put_texture(out, "emissiveTexture", material.emissive_texture);
    // glTF limits the factor to 0..1; division by a power of two is exact.
    const float largest = std::max({material.emissive.r, material.emissive.g, material.emissive.b});
    const float strength = largest > 1.0f ? std::exp2(std::ceil(std::log2(largest))) : 1.0f;
    if (largest > 0.0f) (*out)["emissiveFactor"] = to_json(material.emissive / strength);
    if (strength > 1.0f) put_extension(out, "KHR_materials_emissive_strength", {{"emissiveStrength", strength}});
    if (material.alpha_mode != AlphaMode::opaque)
      (*out)["alphaMode"] = material.alpha_mode == AlphaMode::mask ? "MASK" : "BLEND";
    put_number(out, "alphaCutoff", material.alpha_cutoff, 0.5f);
    if (material.double_sided) (*out)["doubleSided"] = true;
    if (material.unlit) {
      extensions_.insert("KHR_materials_unlit");
      (*out)["extensions"]["KHR_materials_unlit"] = Json::object();
    }
  }

  void write_layers(const Material& material, Json* out) {
    Json coat = Json::object(), transmission = Json::object(), volume = Json::object(), ior = Json::object(),
         specular = Json::object(), sheen = Json::object();
    put_number(&coat, "clearcoatFactor", material.clearcoat, 0.0f);
    put_number(&coat, "clearcoatRoughnessFactor", material.clearcoat_roughness, 0.0f);
    put_texture(&coat, "clearcoatTexture", material.clearcoat_texture);
    put_texture(&coat, "clearcoatRoughnessTexture", material.clearcoat_roughness_texture);
    put_texture(&coat, "clearcoatNormalTexture", material.clearcoat_normal_texture);
    if (material.clearcoat_normal_texture)
      put_number(&coat["clearcoatNormalTexture"], "scale", material.clearcoat_normal_scale, 1.0f);
    put_number(&transmission, "transmissionFactor", material.transmission, 0.0f);
    put_texture(&transmission, "transmissionTexture", material.transmission_texture);
    put_number(&volume, "thicknessFactor", material.thickness, 0.0f);
    put_texture(&volume, "thicknessTexture", material.thickness_texture);
    if (std::isfinite(material.attenuation_distance)) volume["attenuationDistance"] = material.attenuation_distance;
    if (material.attenuation_color != glm::vec3(1.0f)) volume["attenuationColor"] = to_json(material.attenuation_color);
    put_number(&ior, "ior", material.ior, 1.5f);
    put_number(&specular, "specularFactor", material.specular, 1.0f);
    put_texture(&specular, "specularTexture", material.specular_texture);
    if (material.specular_color != glm::vec3(1.0f)) specular["specularColorFactor"] = to_json(material.specular_color);
    put_texture(&specular, "specularColorTexture", material.specular_color_texture);
    if (material.sheen_color != glm::vec3(0.0f)) sheen["sheenColorFactor"] = to_json(material.sheen_color);
    put_texture(&sheen, "sheenColorTexture", material.sheen_color_texture);
    put_number(&sheen, "sheenRoughnessFactor", material.sheen_roughness, 0.0f);
    put_texture(&sheen, "sheenRoughnessTexture", material.sheen_roughness_texture);
    put_extension(out, "KHR_materials_clearcoat", std::move(coat));
    put_extension(out, "KHR_materials_transmission", std::move(transmission));
    put_extension(out, "KHR_materials_volume", std::move(volume));
    put_extension(out, "KHR_materials_ior", std::move(ior));
    put_extension(out, "KHR_materials_specular", std::move(specular));
    put_extension(out, "KHR_materials_sheen", std::move(sheen));
  }

  void write_anisotropy_and_film(const Material& material, Json* out) {
    Json anisotropy = Json::object(), film = Json::object();
    put_number(&anisotropy, "anisotropyStrength", material.anisotropy, 0.0f);
    put_number(&anisotropy, "anisotropyRotation", material.anisotropy_rotation_rad, 0.0f);
    put_texture(&anisotropy, "anisotropyTexture", material.anisotropy_texture);
    put_number(&film, "iridescenceFactor", material.iridescence, 0.0f);
    put_texture(&film, "iridescenceTexture", material.iridescence_texture);
    put_number(&film, "iridescenceIor", material.iridescence_ior, 1.3f);
    put_number(&film, "iridescenceThicknessMinimum", material.iridescence_least_nm, 100.0f);
    put_number(&film, "iridescenceThicknessMaximum", material.iridescence_greatest_nm, 400.0f);
    put_texture(&film, "iridescenceThicknessTexture", material.iridescence_thickness_texture);
    put_extension(out, "KHR_materials_anisotropy", std::move(anisotropy));
    put_extension(out, "KHR_materials_iridescence", std::move(film));
  }

  void write_extras(const Material& material, Json* out) {
    Json extras = Json::object();
    if (!material.measured.empty()) extras["measured"] = beside_file(material.measured);
    if (material.tint_measured) extras["tint_measured"] = true;
    if (material.glass != may_transmit(material)) extras["glass"] = material.glass;
    if (!extras.empty()) (*out)["extras"]["maquette"] = std::move(extras);
  }

  std::string beside_file(const std::string& measured) const {
    if (measured.starts_with("builtin:")) return measured;
    const std::filesystem::path table = std::filesystem::absolute(measured).lexically_normal();
    const std::filesystem::path folder = std::filesystem::absolute(path_).lexically_normal().parent_path();
    const std::string relative = table.lexically_relative(folder).string();
    return relative.empty() || relative.starts_with("..") ? table.string() : relative;
  }

  const std::string& path_;
  Json& root_;
  std::set<std::string>& extensions_;
  std::map<std::array<int, 3>, int> samplers_;
  std::map<std::array<int, 2>, int> textures_;
};

}  // namespace

std::vector<Json> materials_to_json(const Scene& scene, const std::string& path, Json* root,
                                    std::set<std::string>* extensions) {
  MaterialWriter writer(path, root, extensions);
  std::vector<Json> out;
  for (const Material& material : scene.materials) out.push_back(writer.write(material));
  return out;
}

}  // namespace maquette
