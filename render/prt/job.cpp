#include "render/prt/job.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "render/parts/baked_parts.h"
#include "render/prt/buffers.h"
#include "render/prt/material_btf.h"
#include "render/prt/transfer_files.h"
#include "render/scene_state/facts.h"
#include "render/scene_state/material_overrides.h"
#include "scenes/error.h"
#include "scenes/ground.h"

namespace maquette {

namespace {

Material material_of(const TransferInput& input, const DrawItem& item) {
  const int index = material_of_item(*input.scene, item, input.variant);
  return index >= 0 ? input.scene->materials[static_cast<std::size_t>(index)] : Material();
}

bool is_opaque(const Material& material) {
  return !(pane_share(material) > 0.0f) && material.alpha_mode != AlphaMode::blend;
}

/// A line for each material of which parts of the mode get no light, or whose shadows on them are not as they should
/// be.
std::vector<std::string> find_left_out(const TransferInput& input, bool parts_alone) {
  const std::vector<bool> named = named_nodes(*input.scene, input.settings.get_string("prt.parts"));
  std::vector<std::string> lines;
  const auto say = [&](const std::string& line) {
    if (std::find(lines.begin(), lines.end(), line) == lines.end()) lines.push_back(line);
  };
  for (const DrawItem& item : input.geometry->items) {
    const auto node = static_cast<std::size_t>(std::max(item.node, 0));
    if (item.node >= 0 && !input.scene->nodes[node].visible) continue;
    const bool wanted = item.node < 0 || (named[node] && (input.nodes.empty() || input.nodes[node]));
    const Material material = material_of(input, item);
    if (wanted && !is_opaque(material))
      say("no transfer for surfaces of " + material.name +
          ": they are glass or blended, and their own light is missing");
    if (parts_alone && !wanted) continue;
    if (material.alpha_mode == AlphaMode::mask)
      say("radiance transfer takes surfaces of " + material.name +
          " as whole where they cast shadows: they are cut out");
    if (material.alpha_mode == AlphaMode::blend)
      say("radiance transfer has no shadow of surfaces of " + material.name + ": they are blended");
  }
  return lines;
}

std::string part_name(const Scene& scene, const DrawItem& item) {
  const std::string name = item.node >= 0 ? scene.nodes[static_cast<std::size_t>(item.node)].name : std::string();
  return name.empty() ? "node " + std::to_string(item.node) : "part " + name;
}

bool is_shown(const TransferInput& input, const DrawItem& item) {
  return item.node < 0 || input.scene->nodes[static_cast<std::size_t>(item.node)].visible;
}

/// Geometry and materials alone: nothing is traced with it.
std::shared_ptr<const PathScene> material_scene(const TransferInput& input, MeasuredLibrary* library) {
  auto dark = std::make_shared<Environment>();
  dark->width = 32;
  dark->height = 16;
  dark->rgb.assign(32 * 16, glm::vec3(0.0f));
  return build_path_scene({.scene = *input.scene,
                           .environment = dark,
                           .variant = input.variant,
                           .geometry = input.geometry.get(),
                           .library = library});
}

/// Whether a material's texels are of a size of their own.
bool is_btf_of(const PathScene& scene, int material) {
  return material >= 0 && scene.materials[static_cast<std::size_t>(material)].btf;
}

/// The material of an item's first traced triangle, seen along its normal.
std::shared_ptr<const Btf> material_of_first_triangle(const PathScene& scene, const DrawItem& item,
                                                      const std::vector<TextureImage>& images) {
  for (std::uint32_t i = 0; i < scene.triangles.size(); ++i) {
    const TracedTriangle& t = scene.triangles[i];
    if (3 * t.source < item.first_index || 3 * t.source >= item.first_index + item.index_count) continue;
    const glm::vec3 middle = (t.positions[0] + t.positions[1] + t.positions[2]) / 3.0f;
    SurfacePoint p =
        resolve_surface(scene, {middle + t.geometric, -t.geometric}, {1.0f, i, glm::vec2(1.0f / 3.0f)}, {});
    return make_material_btf(p, images);
  }
  return nullptr;
}

void require_finite(const Material& material, const Btf& btf) {
  for (const BtfView& view : btf.views)
    for (const float w : view.light_weights)
      if (!std::isfinite(w))
        throw Error("material " + material.name, "a light weight of its BTF is not finite", "make the BTF again");
}

TransferOptions options_of(const Settings& settings) {
  TransferOptions options;
  options.faces = settings.get_int("prt.faces");
  options.rays = settings.get_int("prt.rays");
  options.clusters = settings.get_int("prt.clusters");
  options.components = settings.get_int("prt.components");
  options.btf_components = settings.get_int("prt.btf_components");
  options.btf_error = 0.01 * settings.get_double("prt.btf_error");
  options.bounces = settings.get_int("prt.bounces");
  options.vertices = static_cast<std::size_t>(settings.get_int("prt.vertices"));
  options.texel_clusters = settings.get_int("prt.texel_clusters");
  options.joint_clusters = settings.get_int("prt.joint_clusters");
  options.parts_alone = settings.get_string("prt.shadows") == "parts";
  if ((options.faces & (options.faces - 1)) != 0)
    throw Error("prt.faces=" + std::to_string(options.faces), "Haar coefficients need a power of two",
                "take 8, 16 or 32");
  return options;
}

/// Of all parts together, where an error divides their triangles.
constexpr std::size_t kMostVerticesByError = 200000;
/// Records of vertices by views, of 81 views: from so many bytes on a scene gets the joint form.
constexpr std::size_t kMostBytesByViews = std::size_t{256} << 20;

}  // namespace

TransferForm choose_transfer_form(const Settings& settings, const SceneFacts& facts) {
  const std::string& asked = settings.get_string("prt.form");
  if (asked != "auto") return {asked == "joint", "prt.form=" + asked};
  const std::size_t vertices =
      std::max(static_cast<std::size_t>(settings.get_int("prt.vertices")), facts.triangle_count / 2);
  const int components = std::min(settings.get_int("prt.btf_components"), facts.has_btf ? kMostMaterialComponents : 2);
  const auto records = static_cast<std::size_t>(1 + 81 * components);
  const std::size_t bytes =
      vertices * records * sizeof(std::uint16_t) * static_cast<std::size_t>(1 + settings.get_int("prt.components"));
  const std::string size =
      "about " + std::to_string(vertices) + " vertices by 81 views: " + std::to_string(bytes >> 20) + " MiB of weights";
  if (bytes > kMostBytesByViews) return {true, size + ", more than " + std::to_string(kMostBytesByViews >> 20)};
  return {false, size};
}

std::string check_transfer_part(const FlatGeometry& geometry, const DrawItem& item, const Material& material) {
  if (material.measured.empty() || material.tint_measured) {
    const auto first = geometry.colors.begin() + static_cast<std::ptrdiff_t>(item.first_vertex);
    if (std::any_of(first, first + static_cast<std::ptrdiff_t>(item.vertex_count),
                    [](const glm::vec4& color) { return glm::vec3(color) != glm::vec3(1.0f); }))
      return "its vertices have colours";
  }
  if (material.double_sided && item.patch < 0 && (material.alpha_mode == AlphaMode::mask || !is_closed(geometry, item)))
    return "it is two-sided and open, and transfer has no light for its back";
  return {};
}

std::vector<std::size_t> find_transfer_items(const TransferInput& input) {
  const std::vector<bool> named = named_nodes(*input.scene, input.settings.get_string("prt.parts"));
  std::vector<std::size_t> items;
  for (std::size_t i = 0; i < input.geometry->items.size(); ++i) {
    const DrawItem& item = input.geometry->items[i];
    const auto node = static_cast<std::size_t>(std::max(item.node, 0));
    if (item.node >= 0 && (!named[node] || (!input.nodes.empty() && !input.nodes[node]))) continue;
    // The light that is projected on a ground turns with the sky: transfer cannot hold it.
    if (item.node >= 0 && is_added_ground(*input.scene, node)) continue;
    if (is_shown(input, item) && is_opaque(material_of(input, item))) items.push_back(i);
  }
  return items;
}

TransferJob make_transfer_job(const TransferInput& input, const std::string& folder, MeasuredLibrary* library,
                              const std::atomic<bool>* cancel) {
  TransferJob job;
  job.scene = input.scene->name;
  job.geometry = input.geometry;
  job.options = options_of(input.settings);
  job.options.joint = choose_transfer_form(input.settings, compute_facts(*input.scene, input.variant)).joint;
  const std::vector<std::size_t> items = find_transfer_items(input);
  for (const std::size_t i : items) {
    const DrawItem& item = input.geometry->items[i];
    const Material material = material_of(input, item);
    if (const std::string fault = check_transfer_material(material); !fault.empty())
      throw Error(
          "material " + material.name, "precomputed radiance transfer cannot hold it: " + fault,
          "shade its parts by another mode (--mode-of), leave them out (prt.parts), or give it another material "
          "(--material)");
    if (const std::string fault = check_transfer_part(*input.geometry, item, material); !fault.empty())
      throw Error(part_name(*input.scene, item), "precomputed radiance transfer cannot hold it: " + fault,
                  "shade it by another mode (--mode-of), or leave it out (prt.parts)");
  }
  job.left_out = find_left_out(input, job.options.parts_alone);
  const std::shared_ptr<const PathScene> scene = material_scene(input, library);
  std::map<int, std::uint32_t> group_of_material;
  job.occluding.assign(input.geometry->items.size(), false);
  for (const std::size_t i : items) {
    const DrawItem& item = input.geometry->items[i];
    const int index = material_of_item(*input.scene, item, input.variant);
    auto found = group_of_material.find(index);
    if (found == group_of_material.end()) {
      const auto btf = material_of_first_triangle(*scene, item, input.scene->images);
      if (!btf) continue;
      require_finite(material_of(input, item), *btf);
      found = group_of_material.emplace(index, static_cast<std::uint32_t>(job.materials.size())).first;
      job.materials.push_back(btf);
    }
    const Btf& btf = *job.materials[found->second];
    TransferPart part{i, found->second, 0.0f, 0.0f};
    if (const Material own = material_of(input, item); own.base_color_texture && !is_btf_of(*scene, index)) {
      part.tiles_per_uv_x = own.base_color_texture.scale.x;
      part.tiles_per_uv_y = own.base_color_texture.scale.y;
    } else if (is_btf_of(*scene, index)) {
      const double side = metres_per_uv(*input.geometry, item);
      part.tiles_per_uv_x = static_cast<float>(side / btf.width_m());
      part.tiles_per_uv_y = static_cast<float>(side / btf.height_m());
    }
    job.parts.push_back(part);
    job.occluding[i] = true;
  }
  if (!job.options.parts_alone)
    for (std::size_t i = 0; i < job.occluding.size(); ++i)
      job.occluding[i] =
          is_shown(input, input.geometry->items[i]) && is_opaque(material_of(input, input.geometry->items[i]));
  if (const double error = 0.01 * input.settings.get_double("prt.vertex_error"); error > 0.0) {
    const std::atomic<bool> never{false};
    job.densities = choose_vertex_density(*job.geometry, build_ray_scene(*job.geometry, job.occluding), error,
                                          kMostVerticesByError, cancel ? *cancel : never, &job.parts);
  }
  const std::string& named = folder.empty() ? input.settings.get_string("prt.bake") : folder;
  job.key = transfer_key(provenance_of(job, make_transfer_mesh(*job.geometry, job.parts, job.options.vertices)));
  job.folder = transfer_folder(named, job.scene, job.key);
  job.must_work = !named.empty();
  job.may_make = named.empty();
  job.show_stale = input.settings.get_string("prt.stale") == "show";
  return job;
}

}  // namespace maquette
