#include "render/slf/incident_contents.h"

#include <cmath>
#include <cstdlib>
#include <numbers>
#include <set>
#include <sstream>

#include "render/bake/bake_attributes.h"
#include "render/bake/kept_bakes.h"
#include "render/btf/btf_source.h"
#include "render/lights/light_numbers.h"
#include "render/parts/baked_parts.h"
#include "render/scene_state/geometry.h"
#include "render/slf/incident_bake.h"
#include "scenes/node_paths.h"
#include "scenes/suggest.h"

namespace maquette {

namespace {

constexpr const char *kSurfaces = "list.surfaces", *kParts = "list.parts", *kMaterials = "list.materials",
                     *kShown = "list.shown", *kLight = "list.light";
constexpr std::size_t kMostNames = 4;  // in a message

std::uint64_t read_hash(const std::string& text) { return std::strtoull(text.c_str(), nullptr, 16); }

std::string some_of(const std::vector<std::string>& names) {
  if (names.size() <= kMostNames) return join(names);
  return join({names.begin(), names.begin() + kMostNames}) + " and " + std::to_string(names.size() - kMostNames) +
         " more";
}

std::string path_of_item(const std::vector<std::string>& paths, const DrawItem& item) {
  return item.node < 0 ? "/" : paths[static_cast<std::size_t>(item.node)];
}

std::map<std::string, std::string> light_of(const IncidentJob& job) {
  std::map<std::string, std::string> light;
  char text[40];
  std::snprintf(text, sizeof text, "%.6g",
                static_cast<double>(job.options.env_rotation_rad) * 180.0 / std::numbers::pi);
  light["rotation in degrees"] = text;
  std::snprintf(text, sizeof text, "%.6g", static_cast<double>(job.options.env_scale));
  light["scale"] = text;
  if (job.environment)
    light["environment"] = job.environment->name + " (" + hex(chain_hash(job.environment->rgb, 0)).substr(0, 8) + ")";
  std::vector<float> lamps = light_numbers(*job.scene);
  for (const Material& m : job.scene->materials) lamps.insert(lamps.end(), {m.emissive.x, m.emissive.y, m.emissive.z});
  light["lamps and what glows"] = hex(chain_hash(lamps, 0)).substr(0, 8);
  return light;
}

/// Without the texels of its textures.
std::uint64_t hash_of(const Material& material) {
  const bool file = !material.measured.empty() && !material.measured.starts_with("builtin:");
  return chain_hash(numbers_of(material), content_hash(std::as_bytes(std::span(material.measured)),
                                                       file ? material_source_key(material.measured) : 0));
}

}  // namespace

std::vector<std::uint64_t> looks_of(const Scene& scene) {
  std::vector<std::uint64_t> images;
  for (const TextureImage& image : scene.images) images.push_back(chain_hash(image.rgba16, chain_hash(image.rgba, 0)));
  std::vector<std::uint64_t> looks;
  for (const Material& material : scene.materials) {
    std::vector<std::uint64_t> read{hash_of(material)};
    for (const auto texture : kMaterialTextures)
      if (const int image = (material.*texture).image; image >= 0 && image < static_cast<int>(images.size()))
        read.push_back(images[static_cast<std::size_t>(image)]);
    looks.push_back(chain_hash(read, 0));
  }
  return looks;
}

std::map<std::string, std::uint64_t> shown_in(const Scene& scene, const FlatGeometry& geometry, int variant) {
  const std::vector<std::string> paths = node_paths(scene);
  std::map<std::string, std::uint64_t> shown;
  for (const DrawItem& item : geometry.items) {
    std::uint64_t& hash = shown[path_of_item(paths, item)];
    hash = chain_hash(std::vector<int>{material_of_item(scene, item, variant)}, hash);
  }
  return shown;
}

IncidentContents contents_of(const IncidentJob& job) {
  IncidentContents contents;
  const std::vector<std::string> paths = node_paths(*job.scene);
  const FlatGeometry& g = *job.geometry;
  for (const DrawItem& item : g.items) {
    if (item.node >= 0 && !job.scene->nodes[static_cast<std::size_t>(item.node)].visible) continue;
    std::vector<glm::vec3> corners;
    std::vector<glm::vec4> colors, coordinates;
    for (std::uint32_t i = item.first_index; i < item.first_index + item.index_count; ++i) {
      const std::uint32_t v = g.indices[i];
      corners.push_back(g.positions[v]);
      colors.push_back(g.colors[v]);
      coordinates.emplace_back(g.uv0[v], g.uv1[v]);
    }
    std::uint64_t& hash = contents.surfaces[path_of_item(paths, item)];
    hash = chain_hash(coordinates, chain_hash(colors, chain_hash(corners, hash)));
  }
  contents.shown = shown_in(*job.scene, g, job.variant);
  std::set<std::string> parts;
  for (const AtlasPart& part : job.parts) parts.insert(path_of_item(paths, g.items[part.item]));
  contents.parts.assign(parts.begin(), parts.end());
  contents.materials = looks_of(*job.scene);
  contents.light = light_of(job);
  return contents;
}

void write_contents(const IncidentContents& contents, std::map<std::string, std::string>* attributes) {
  std::string &surfaces = (*attributes)[kSurfaces], &parts = (*attributes)[kParts],
              &materials = (*attributes)[kMaterials];
  for (const auto& [path, hash] : contents.surfaces) surfaces += hex(hash) + " " + path + "\n";
  for (const std::string& path : contents.parts) parts += path + "\n";
  for (const std::uint64_t hash : contents.materials) materials += hex(hash) + "\n";
  std::string& shown = (*attributes)[kShown];
  for (const auto& [path, hash] : contents.shown) shown += hex(hash) + " " + path + "\n";
  std::string& light = (*attributes)[kLight];
  for (const auto& [what, value] : contents.light) light += what + "\t" + value + "\n";
}

IncidentContents read_contents(const std::map<std::string, std::string>& attributes) {
  IncidentContents contents;
  const auto for_each_line = [&](const char* name, const auto& read) {
    const auto found = attributes.find(name);
    std::istringstream stream(found == attributes.end() ? std::string() : found->second);
    for (std::string line; std::getline(stream, line);) read(line);
  };
  for (const auto& [name, hashes] : {std::pair{kSurfaces, &contents.surfaces}, {kShown, &contents.shown}})
    for_each_line(name, [&, hashes = hashes](const std::string& line) {
      const std::size_t space = line.find(' ');
      if (space != std::string::npos) (*hashes)[line.substr(space + 1)] = read_hash(line.substr(0, space));
    });
  for_each_line(kParts, [&](const std::string& line) { contents.parts.push_back(line); });
  for_each_line(kMaterials, [&](const std::string& line) { contents.materials.push_back(read_hash(line)); });
  for_each_line(kLight, [&](const std::string& line) {
    const std::size_t tab = line.find('\t');
    if (tab != std::string::npos) contents.light[line.substr(0, tab)] = line.substr(tab + 1);
  });
  return contents;
}

std::string light_difference(const IncidentContents& baked, const IncidentContents& now) {
  std::vector<std::string> differences;
  for (const auto& [what, value] : now.light) {
    const auto found = baked.light.find(what);
    if (found != baked.light.end() && found->second != value)
      differences.push_back(what + " " + found->second + ", now " + value);
  }
  return join(differences, "; ");
}

std::string name_difference(const IncidentContents& baked, const IncidentContents& now) {
  std::vector<std::string> moved, gone, added, texels, without;
  for (const auto& [path, hash] : now.surfaces) {
    const auto found = baked.surfaces.find(path);
    if (found == baked.surfaces.end())
      added.push_back(path);
    else if (found->second != hash)
      moved.push_back(path);
  }
  for (const auto& [path, hash] : baked.surfaces)
    if (!now.surfaces.contains(path)) gone.push_back(path);
  const std::set<std::string> before(baked.parts.begin(), baked.parts.end()), after(now.parts.begin(), now.parts.end());
  for (const std::string& path : after)
    if (!before.contains(path)) texels.push_back(path);
  for (const std::string& path : before)
    if (!after.contains(path)) without.push_back(path);
  std::vector<std::string> differences;
  const auto add = [&](const char* what, const std::vector<std::string>& names) {
    if (!names.empty()) differences.push_back(what + some_of(names));
  };
  add("moved, dented or recoloured: ", moved);
  add("not there any more: ", gone);
  add("new: ", added);
  add("without texels in it: ", texels);
  add("with texels only in it: ", without);
  return join(differences, "; ");
}

}  // namespace maquette
