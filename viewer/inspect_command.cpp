#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "render/btf/btf_source.h"
#include "render/btf/builtin_geometry.h"
#include "render/environment/environment_tables.h"
#include "render/materials/brdf_tables.h"
#include "render/parts/parts.h"
#include "review/review.h"
#include "scenes/btf/btf_file.h"
#include "scenes/error.h"
#include "scenes/files.h"
#include "scenes/luminance.h"
#include "scenes/suggest.h"
#include "viewer/command_line.h"
#include "viewer/commands.h"
#include "viewer/inspect_bake.h"
#include "viewer/inspect_btf.h"
#include "viewer/inspect_review.h"
#include "viewer/json_values.h"
#include "viewer/report_text.h"
#include "viewer/session.h"

namespace maquette {

namespace {

using Json = nlohmann::ordered_json;

constexpr double kHalfPi = 1.5707963267948966;
const std::vector<std::string> kBuiltinScenes = {"cockpit", "sphere", "plate", "cornell", "seat"};

Json rgb_json(const glm::vec3& rgb) { return {number(rgb.r), number(rgb.g), number(rgb.b)}; }

/// Median, 95 % and maximum.
Json distribution_json(std::vector<float> values) {
  if (values.empty()) return nullptr;
  std::sort(values.begin(), values.end());
  const auto at = [&](double q) {
    return number(values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))]);
  };
  return {{"median", at(0.5)}, {"p95", at(0.95)}, {"max", at(1.0)}};
}

std::string material_kind(const Material& material) {
  if (material.glass) return "glass";
  if (!material.measured.empty()) return "measured: " + material.measured;
  if (material.unlit) return "unlit";
  std::string text = material.metallic > 0.5f ? "analytic, metal" : "analytic";
  char roughness[32];
  std::snprintf(roughness, sizeof(roughness), ", roughness %.2g", static_cast<double>(material.roughness));
  text += roughness;
  if (material.clearcoat > 0.0f) text += ", clear coat";
  if (material.sheen_color != glm::vec3(0.0f)) text += ", sheen";
  if (material.emissive != glm::vec3(0.0f)) text += ", emissive";
  if (material.alpha_mode != AlphaMode::opaque)
    text += material.alpha_mode == AlphaMode::mask ? ", cut out" : ", blended";
  return text;
}

/// Bytes of GPU memory by kind, computed from the layouts of render/scene_state/geometry.h and of the tables.
Json memory_json(const Scene& scene) {
  std::size_t vertices = 0, indices = 0, texels = 0;
  for (const Node& node : scene.nodes) {
    if (node.mesh < 0 || !node.visible) continue;
    for (const Primitive& primitive : scene.meshes[static_cast<std::size_t>(node.mesh)].primitives) {
      vertices += primitive.positions.size();
      indices += primitive.indices.size();
    }
  }
  for (const TextureImage& image : scene.images) texels += image.rgba.size() / 4;
  std::vector<std::string> measured;
  for (const Material& material : scene.materials)
    if (!material.measured.empty() && std::find(measured.begin(), measured.end(), material.measured) == measured.end())
      measured.push_back(material.measured);
  constexpr std::size_t kVertexBytes = sizeof(glm::vec3) * 2 + sizeof(glm::vec4) * 2 + sizeof(glm::vec2) * 2;
  return {{"geometry", vertices * kVertexBytes + indices * sizeof(std::uint32_t)},
          {"textures", texels * 4 * 4 / 3},
          {"brdf_tables", measured.size() * kBrdfEntryCount * sizeof(glm::vec3)}};
}

/// Values as a person would write them, for lists of points.
double rounded(float value) { return std::round(static_cast<double>(value) * 1e4) / 1e4; }
Json point_json(const glm::vec3& p) { return {rounded(p.x), rounded(p.y), rounded(p.z)}; }

Json cameras_json(const Scene& scene) {
  Json cameras = Json::array();
  for (const std::string& name : camera_names(scene)) {
    const CameraView view = camera_by_name(scene, name);
    Json camera = {{"name", name}, {"eye_m", point_json(view.eye)}, {"target_m", point_json(view.target)}};
    if (view.is_orthographic())
      camera["height_m"] = rounded(view.height_m);
    else
      camera["fov_deg"] = rounded(glm::degrees(view.fov_y_rad));
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

/// Nodes by path, with what they show. `most`: how many are listed before the rest is only counted.
Json nodes_json(const Scene& scene, std::size_t most) {
  Json nodes = Json::array();
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    if (i == most) {
      nodes.push_back("and " + std::to_string(scene.nodes.size() - most) + " more: --json lists all");
      break;
    }
    const Node& node = scene.nodes[i];
    Json entry = {{"path", node_path(scene, static_cast<int>(i))}};
    if (node.camera >= 0) entry["shows"] = "camera";
    if (node.mesh >= 0) {
      std::size_t triangles = 0;
      std::vector<std::string> names;
      for (const Primitive& primitive : scene.meshes[static_cast<std::size_t>(node.mesh)].primitives) {
        triangles += primitive.indices.size() / 3;
        const std::string name =
            primitive.material < 0 ? "" : scene.materials[static_cast<std::size_t>(primitive.material)].name;
        if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
      }
      entry["shows"] = std::to_string(triangles) + " triangles";
      if (!names.empty()) entry["materials"] = join(names);
    }
    if (node.patch >= 0) {
      const int material = scene.patches[static_cast<std::size_t>(node.patch)].material;
      entry["shows"] = "a Bezier patch";
      if (material >= 0) entry["materials"] = scene.materials[static_cast<std::size_t>(material)].name;
    }
    if (node.reflector) entry["reflector"] = "a reflector";
    if (!node.visible) entry["hidden"] = "hidden";
    nodes.push_back(std::move(entry));
  }
  return nodes;
}

Json inspect_scene(const CommandLine& line) {
  SceneOptions options = line.options;
  options.scene = line.files[0];
  const std::shared_ptr<Scene> scene = load_session_scene(options);
  const int variant = find_variant(*scene, options.variant);
  const SceneFacts facts = compute_facts(*scene, variant);
  const Bounds bounds = compute_bounds(*scene);
  std::size_t primitives = 0, cages = 0;
  for (const Mesh& mesh : scene->meshes) {
    primitives += mesh.primitives.size();
    cages += mesh.cage ? 1 : 0;
  }
  Json json;
  json["kind"] = "scene";
  json["name"] = scene->name;
  json["nodes"] = scene->nodes.size();
  json["meshes"] = scene->meshes.size();
  json["primitives"] = primitives;
  json["triangles"] = facts.triangle_count;
  json["subdivision_surfaces"] = cages;
  json["bezier_patches"] = scene->patches.size();
  json["textures"] = scene->images.size();
  json["lights"] = scene->lights.size();
  if (!bounds.empty()) {
    json["bounds_min_m"] = rgb_json(bounds.min);
    json["bounds_max_m"] = rgb_json(bounds.max);
  }
  json["closes_the_eye_in"] = facts.enclosed;
  json["cameras"] = cameras_json(*scene);
  for (const Animation& animation : scene->animations)
    json["animations"].push_back({{"name", animation.name},
                                  {"duration_s", number(animation.duration_s)},
                                  {"moves", std::to_string(animation.nodes.size()) + " nodes"}});
  json["variants"] = scene->variants;
  json["materials"] = Json::array();
  for (const Material& material : scene->materials)
    json["materials"].push_back(
        {{"name", material.name.empty() ? "(unnamed)" : material.name}, {"kind", material_kind(material)}});
  constexpr std::size_t kListedNodes = 300;
  json["scene_tree"] = nodes_json(*scene, line.json ? scene->nodes.size() : kListedNodes);
  json["warnings"] = scene->warnings;
  json["gpu_bytes"] = memory_json(*scene);
  ViewInfo view{options.width, options.height, options.msaa, options.reflections};
  view.part_modes = options.part_modes;
  layers_of_nodes(*scene, options.part_modes, {});  // names every node
  const FramePlan made = plan(facts, options.mode, options.settings, view);
  json["mode"] = made.shading().mode;
  json["plan"] = plan_json(made);
  json["left_out"] = left_out_json(made);
  return json;
}

Json inspect_brdf(const std::string& source) {
  const BrdfTable table = load_brdf(source);
  const BrdfTables derived = load_brdf_tables(table);
  const GgxFit ggx = fit_ggx(table);
  double lowest = INFINITY, highest = 0.0;
  for (const glm::vec3& rgb : table.rgb) {
    lowest = std::min(lowest, luminance(glm::dvec3(rgb)));
    highest = std::max(highest, luminance(glm::dvec3(rgb)));
  }
  Json json;
  json["kind"] = "BRDF";
  json["name"] = table.name;
  json["entries"] = table.rgb.size();
  json["unmeasured_share"] = number(static_cast<double>(table.unmeasured_count) / static_cast<double>(kBrdfEntryCount));
  json["luminance_min_per_sr"] = number(lowest);
  json["luminance_max_per_sr"] = number(highest);
  json["albedo"] = Json::object();
  for (const int degrees : {0, 45, 75}) {
    const auto i = static_cast<std::size_t>(std::lround(degrees / 90.0 * (kAlbedoCount - 1)));
    json["albedo"]["at_" + std::to_string(degrees) + "_degrees"] = rgb_json(derived.albedo[i]);
  }
  json["bandwidth_cycles_per_rad"] = distribution_json(derived.bandwidth);
  json["ggx_fit"] = {{"diffuse", rgb_json(ggx.diffuse)},
                     {"specular", rgb_json(ggx.specular)},
                     {"alpha", number(ggx.alpha)},
                     {"relative_error", number(ggx.relative_error)}};
  json["gpu_bytes"] = {
      {"brdf_tables", table.rgb.size() * sizeof(glm::vec3)},
      {"importance", derived.theta_cells.size() * sizeof(glm::vec2) + derived.phi_cells.size() * sizeof(glm::vec2)}};
  return json;
}

Json inspect_environment(const std::string& source) {
  const Environment environment = load_environment(source);
  const EnvironmentTables tables = load_environment_tables(environment);
  double peak = 0.0;
  for (const glm::vec3& rgb : environment.rgb) peak = std::max(peak, luminance(glm::dvec3(rgb)));
  const double mean = tables.luminance_integral / (8.0 * kHalfPi);
  Json json;
  json["kind"] = "environment";
  json["name"] = environment.name;
  json["size"] = {environment.width, environment.height};
  json["mean_luminance"] = number(mean);
  json["peak_luminance"] = number(peak);
  json["peak_over_mean"] = mean > 0.0 ? number(peak / mean) : Json(nullptr);
  json["bandwidth_cycles_per_rad"] = distribution_json(tables.bandwidth);
  json["warnings"] = environment.warnings;
  json["gpu_bytes"] = {{"environment", environment.rgb.size() * sizeof(glm::vec3)},
                       {"importance", (tables.marginal_cdf.size() + tables.conditional_cdf.size()) * sizeof(float)}};
  return json;
}

Json inspect_library() {
  Json json;
  json["materials"] = Json::array();
  for (const BuiltinBrdf& brdf : builtin_brdfs())
    json["materials"].push_back({{"name", "builtin:" + brdf.name}, {"label", brdf.label}, {"model", brdf.model}});
  for (const BuiltinGeometry& btf : builtin_geometries())
    json["materials"].push_back({{"name", "builtin:" + btf.name}, {"label", btf.label}, {"model", btf.model}});
  json["environments"] = Json::array();
  for (const std::string& name : builtin_environment_names()) json["environments"].push_back("builtin:" + name);
  json["scenes"] = Json::array();
  for (const std::string& name : kBuiltinScenes) json["scenes"].push_back("builtin:" + name);
  return json;
}

bool is_one_of(const std::string& name, const std::vector<std::string>& names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

Json inspect_builtin(const CommandLine& line, const std::string& name) {
  std::vector<std::string> brdfs;
  for (const BuiltinBrdf& brdf : builtin_brdfs()) brdfs.push_back(brdf.name);
  const std::vector<std::string> environments = builtin_environment_names();
  if (is_one_of(name, kBuiltinScenes)) return inspect_scene(line);
  if (is_one_of(name, environments)) return inspect_environment("builtin:" + name);
  if (is_one_of(name, brdfs)) return inspect_brdf("builtin:" + name);
  std::vector<std::string> all = kBuiltinScenes;
  all.insert(all.end(), environments.begin(), environments.end());
  all.insert(all.end(), brdfs.begin(), brdfs.end());
  throw UsageError("builtin:" + name, "nothing built in has this name", did_you_mean(name, all));
}

Json inspect(const CommandLine& line) {
  const std::string& source = line.files[0];
  if (source == "library") return inspect_library();
  if (const auto bake = inspect_bake(line)) return *bake;
  if (is_review_file(source)) return inspect_review(source);
  if (line.files.size() > 1)
    throw UsageError(line.files[1], "only a bake is inspected with its scene", "leave it out, or name a bake's folder");
  const std::string btf = with_btf_reading(source, line.options.settings);
  if (is_btf_source(source) && (lower_extension(source) != ".exr" || is_factorised_btf(source)))
    return inspect_btf(btf);
  if (source.starts_with("builtin:")) return inspect_builtin(line, source.substr(8));
  const std::string extension = lower_extension(source);
  if (extension == ".gltf" || extension == ".glb") return inspect_scene(line);
  if (extension == ".binary") return inspect_brdf(source);
  if (extension == ".hdr" || extension == ".exr") return inspect_environment(source);
  std::error_code error;
  if (!std::filesystem::exists(source, error))
    throw Error(source, "does not exist", "check the path; `maquette inspect library` lists what is built in");
  throw UsageError(source,
                   "neither a scene (.gltf, .glb), a BRDF (.binary), a BTF (folder, .btf), a bake (folder), an "
                   "environment (.hdr, .exr) nor a review (.maquette.json)",
                   "`maquette inspect library` lists what is built in");
}

}  // namespace

int run_inspect(const CommandLine& line) {
  const Json json = inspect(line);
  print_report(line.json, json);
  return 0;
}

}  // namespace maquette
