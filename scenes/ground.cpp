#include "scenes/ground.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/srgb.h"
#include "scenes/subject_bounds.h"

namespace maquette {

namespace {

/// Radius, in radii of the scene, and at least in heights of the point of view: beyond, the environment itself is seen.
constexpr double kRadii = 6.0, kHeights = 10.0;
constexpr int kAround = 96, kRings = 72;
/// Texture: of the whole circle, and from the nadir to the horizon.
constexpr int kTextureWidth = 1024, kTextureHeight = 512;

/// Distance of ring k from the middle, m: as fine near the scene as its shadows need, with equal steps of the angle far
/// away.
double ring_m(int k, double fine_m, double radius_m) {
  const double t = static_cast<double>(k) / kRings;
  return fine_m * t + (radius_m - fine_m) * t * t * t * t;
}

TextureImage ground_image(const Environment& environment) {
  const glm::dvec3 irradiance = upper_irradiance(environment);
  TextureImage image;
  image.name = kGroundName;
  image.width = kTextureWidth;
  image.height = kTextureHeight;
  image.rgba.resize(static_cast<std::size_t>(4 * kTextureWidth * kTextureHeight), 255);
  for (int y = 0; y < kTextureHeight; ++y) {
    // Row 0 looks to the horizon, the last one down; columns as in the environment.
    const double latitude = -0.5 * std::numbers::pi * (y + 0.5) / kTextureHeight;
    for (int x = 0; x < kTextureWidth; ++x) {
      const double longitude = std::numbers::pi - 2.0 * std::numbers::pi * (x + 0.5) / kTextureWidth;
      const glm::dvec3 direction(std::cos(latitude) * std::sin(longitude), std::sin(latitude),
                                 std::cos(latitude) * std::cos(longitude));
      const glm::dvec3 shown = evaluate_environment(environment, direction);
      std::uint8_t* texel = &image.rgba[static_cast<std::size_t>(4 * (y * kTextureWidth + x))];
      for (int c = 0; c < 3; ++c) {
        const double albedo = irradiance[c] > 0.0 ? std::min(std::numbers::pi * shown[c] / irradiance[c], 1.0) : 0.0;
        texel[c] = static_cast<std::uint8_t>(std::lround(255.0 * srgb_from_linear(albedo)));
      }
    }
  }
  return image;
}

/// Rings around the middle at y = 0, seen from above. u: turns from the environment's left edge; v: 0 at the horizon, 1
/// below.
Primitive ground_disc(double height_m, double fine_m, double radius_m) {
  Primitive disc;
  for (int k = 0; k <= kRings; ++k) {
    const double r = ring_m(k, fine_m, radius_m);
    for (int i = 0; i <= kAround; ++i) {
      const double longitude = std::numbers::pi - 2.0 * std::numbers::pi * i / kAround;
      disc.positions.emplace_back(r * std::sin(longitude), 0.0, r * std::cos(longitude));
      disc.normals.emplace_back(0.0f, 1.0f, 0.0f);
      disc.uvs[0].emplace_back(static_cast<double>(i) / kAround, std::atan2(height_m, r) / (0.5 * std::numbers::pi));
    }
  }
  const auto at = [](int k, int i) { return static_cast<std::uint32_t>(k * (kAround + 1) + i); };
  for (int k = 0; k < kRings; ++k)
    for (int i = 0; i < kAround; ++i)
      for (const std::uint32_t corner :
           {at(k, i), at(k + 1, i + 1), at(k + 1, i), at(k, i), at(k, i + 1), at(k + 1, i + 1)})
        disc.indices.push_back(corner);
  return disc;
}

}  // namespace

glm::dvec3 upper_irradiance(const Environment& environment) {
  glm::dvec3 sum(0.0);
  for (int y = 0; y < environment.height; ++y) {
    // Over each row, the exact integral of the sine of the latitude, above the horizon.
    const double top = std::max(0.5 * std::numbers::pi - std::numbers::pi * y / environment.height, 0.0),
                 bottom = std::max(0.5 * std::numbers::pi - std::numbers::pi * (y + 1) / environment.height, 0.0);
    const double weight = 0.5 * (std::pow(std::sin(top), 2.0) - std::pow(std::sin(bottom), 2.0));
    if (!(weight > 0.0)) continue;
    glm::dvec3 row(0.0);
    for (int x = 0; x < environment.width; ++x)
      row += glm::dvec3(environment.rgb[static_cast<std::size_t>(y) * static_cast<std::size_t>(environment.width) +
                                        static_cast<std::size_t>(x)]);
    sum += row * (weight * 2.0 * std::numbers::pi / environment.width);
  }
  return sum;
}

void remove_ground(Scene* scene) {
  if (scene->nodes.empty() || !is_added_ground(*scene, scene->nodes.size() - 1)) return;
  scene->nodes.pop_back();
  scene->roots.pop_back();
  scene->meshes.pop_back();
  scene->materials.pop_back();
  scene->images.pop_back();
}

bool is_added_ground(const Scene& scene, std::size_t node) {
  if (node >= scene.nodes.size()) return false;
  const Node& n = scene.nodes[node];
  return n.name == kGroundName && n.mesh >= 0 && scene.meshes[static_cast<std::size_t>(n.mesh)].name == kGroundName;
}

glm::vec2 ground_texture_offset(float env_rotation_rad) {
  return {env_rotation_rad / (2.0f * std::numbers::pi_v<float>), 0.0f};
}

bool has_ground(const Scene& scene) {
  const Bounds bounds = subject_bounds(scene);
  if (bounds.empty()) return true;
  const glm::dvec3 size = glm::dvec3(bounds.max) - glm::dvec3(bounds.min);
  const double below = static_cast<double>(bounds.min.y) + 0.02 * std::max(size.y, 1e-9);
  // What lies far below is no ground of this.
  const double above = static_cast<double>(bounds.min.y) - 0.02 * std::max(size.y, 1e-9);
  double level_m2 = 0.0;
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    if (!node.visible || node.mesh < 0) continue;
    for (const Primitive& p : scene.meshes[static_cast<std::size_t>(node.mesh)].primitives)
      for (std::size_t k = 0; k + 2 < p.indices.size(); k += 3) {
        glm::dvec3 corner[3]{};
        for (std::size_t c = 0; c < 3; ++c)
          corner[c] = glm::dvec3(glm::dmat4(world[i]) * glm::dvec4(p.positions[p.indices[k + c]], 1.0));
        const auto [lowest, highest] = std::minmax({corner[0].y, corner[1].y, corner[2].y});
        if (highest > below || lowest < above) continue;
        level_m2 += 0.5 * std::abs(glm::cross(corner[1] - corner[0], corner[2] - corner[0]).y);
      }
  }
  return level_m2 >= 0.5 * size.x * size.z;
}

void add_ground(Scene* scene, const Environment& environment, const GroundOptions& options) {
  const Bounds bounds = subject_bounds(*scene);
  if (bounds.empty()) return;
  const double size_m = std::max(static_cast<double>(bounds.radius()), 1e-6);
  const double height_m = std::max(static_cast<double>(options.height_m), 1e-3 * size_m);
  Material material;
  material.name = kGroundName;
  material.metallic = 0.0f;
  material.roughness = options.roughness;
  material.specular = options.roughness < 1.0f ? 1.0f : 0.0f;
  material.double_sided = true;
  material.base_color_texture.image = static_cast<int>(scene->images.size());
  material.base_color_texture.wrap_t = Wrap::clamp_to_edge;
  scene->images.push_back(ground_image(environment));
  Mesh mesh;
  mesh.name = kGroundName;
  mesh.primitives.push_back(ground_disc(height_m, 3.0 * size_m, std::max(kRadii * size_m, kHeights * height_m)));
  mesh.primitives.back().material = static_cast<int>(scene->materials.size());
  scene->materials.push_back(std::move(material));
  Node node;
  node.name = kGroundName;
  node.mesh = static_cast<int>(scene->meshes.size());
  node.local[3] = glm::vec4(bounds.center().x, bounds.min.y, bounds.center().z, 1.0f);
  scene->meshes.push_back(std::move(mesh));
  scene->roots.push_back(static_cast<int>(scene->nodes.size()));
  scene->nodes.push_back(std::move(node));
}

}  // namespace maquette
