#include "render/lights/light_list.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>

#include "scenes/luminance.h"
#include "scenes/texels.h"

namespace maquette {

static_assert(sizeof(LightRecord) == 64 && offsetof(LightRecord, kind) == 12 &&
              offsetof(LightRecord, direction) == 16 && offsetof(LightRecord, range_m) == 28 &&
              offsetof(LightRecord, color) == 32 && offsetof(LightRecord, selection_pdf) == 44 &&
              offsetof(LightRecord, edge2) == 48 && offsetof(LightRecord, cdf) == 60);

namespace {

/// Most texture lookups along each side of a triangle: 48 x 48 / 2 average a display of 1,000 texels well.
constexpr int kMaxTextureSteps = 48;

struct WeightedLight {
  LightRecord record{};
  double power = 0.0;
  std::uint32_t triangle = kNoTriangle;
};

bool is_finite(const glm::dvec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

int wrap_texel(int i, int size, Wrap wrap) {
  if (wrap == Wrap::clamp_to_edge) return std::clamp(i, 0, size - 1);
  const int period = wrap == Wrap::mirrored_repeat ? 2 * size : size;
  const int m = ((i % period) + period) % period;
  return m < size ? m : 2 * size - 1 - m;
}

/// KHR_texture_transform: offset + rotation * (scale * uv).
glm::dvec2 transform_uv(const TextureRef& texture, const glm::vec2& uv) {
  const glm::dvec2 scaled = glm::dvec2(texture.scale) * glm::dvec2(uv);
  const double c = std::cos(static_cast<double>(texture.rotation_rad));
  const double s = std::sin(static_cast<double>(texture.rotation_rad));
  return glm::dvec2(texture.offset) + glm::dvec2(c * scaled.x + s * scaled.y, c * scaled.y - s * scaled.x);
}

glm::dvec3 nearest_texel(const TextureImage& image, const TextureRef& texture, const Texels& texels,
                         const glm::dvec2& uv) {
  const auto to_int = [](double v) { return static_cast<int>(std::clamp(std::floor(v), -1e9, 1e9)); };
  const int x = wrap_texel(to_int(uv.x * image.width), image.width, texture.wrap_s);
  const int y = wrap_texel(to_int(uv.y * image.height), image.height, texture.wrap_t);
  return glm::dvec3(texels(x, y));
}

/// Mean of the emissive texture over a triangle: a regular grid about as fine as the texels, up to kMaxTextureSteps.
glm::dvec3 mean_emissive_texture(const Scene& scene, const TextureRef& texture, const std::array<glm::vec2, 3>& uv) {
  if (!texture || texture.image >= static_cast<int>(scene.images.size())) return glm::dvec3(1.0);
  const TextureImage& image = scene.images[static_cast<std::size_t>(texture.image)];
  if (image.width <= 0 || image.height <= 0) return glm::dvec3(1.0);
  const Texels texels(image, true);
  std::array<glm::dvec2, 3> at{};
  for (std::size_t k = 0; k < 3; ++k) at[k] = transform_uv(texture, uv[k]);
  const glm::dvec2 size(image.width, image.height);
  double longest = 1.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double edge = glm::length((at[(k + 1) % 3] - at[k]) * size);
    if (!std::isfinite(edge)) return glm::dvec3(1.0);
    longest = std::max(longest, edge);
  }
  const int steps = static_cast<int>(std::min(std::ceil(longest), static_cast<double>(kMaxTextureSteps)));
  // Centroids of the steps^2 equal triangles: upright (i, j) and, between them, inverted ones.
  glm::dvec3 sum(0.0);
  for (int i = 0; i < steps; ++i) {
    for (int j = 0; i + j < steps; ++j) {
      for (int inverted = 0; inverted < (i + j + 1 < steps ? 2 : 1); ++inverted) {
        const double third = inverted ? 2.0 / 3.0 : 1.0 / 3.0;
        const double a = (i + third) / steps;
        const double b = (j + third) / steps;
        sum += nearest_texel(image, texture, texels, at[0] + a * (at[1] - at[0]) + b * (at[2] - at[0]));
      }
    }
  }
  return sum / (static_cast<double>(steps) * steps);
}

const Material* material_of_item(const Scene& scene, const DrawItem& item, int variant) {
  int index = -1;
  if (item.patch >= 0) {
    index = scene.patches[static_cast<std::size_t>(item.patch)].material;
  } else if (item.mesh >= 0 && item.primitive >= 0) {
    const Mesh& mesh = scene.meshes[static_cast<std::size_t>(item.mesh)];
    index = material_of(mesh.primitives[static_cast<std::size_t>(item.primitive)], variant);
  }
  return index >= 0 && index < static_cast<int>(scene.materials.size())
             ? &scene.materials[static_cast<std::size_t>(index)]
             : nullptr;
}

/// The power is 0 where the triangle does not emit.
WeightedLight make_triangle(const Scene& scene, const FlatGeometry& geometry, const Material& material,
                            const std::uint32_t* corner) {
  WeightedLight light;
  std::array<glm::vec2, 3> uv{};
  for (std::size_t k = 0; k < 3; ++k) {
    if (corner[k] >= geometry.positions.size()) return light;
    const auto& set = material.emissive_texture.uv_set == 1 ? geometry.uv1 : geometry.uv0;
    if (corner[k] < set.size()) uv[k] = set[corner[k]];
  }
  const glm::dvec3 a(geometry.positions[corner[0]]);
  const glm::dvec3 e1 = glm::dvec3(geometry.positions[corner[1]]) - a;
  const glm::dvec3 e2 = glm::dvec3(geometry.positions[corner[2]]) - a;
  const glm::dvec3 radiance = glm::max(glm::dvec3(material.emissive), glm::dvec3(0.0)) *
                              mean_emissive_texture(scene, material.emissive_texture, uv);
  const double area = 0.5 * glm::length(glm::cross(e1, e2));
  const double sides = material.double_sided ? 2.0 : 1.0;
  light.power = sides * std::numbers::pi * area * luminance(radiance);
  light.record.position = glm::vec3(a);
  light.record.kind = shared::kLightTriangle;
  light.record.direction = glm::vec3(e1);
  light.record.range_m = material.double_sided ? 1.0f : 0.0f;
  light.record.color = glm::vec3(radiance);
  light.record.edge2 = glm::vec3(e2);
  // Slivers whose area is only rounding error have no orientation.
  const double longest = std::max({glm::length(e1), glm::length(e2), glm::length(e2 - e1)});
  if (!is_finite(a) || !(2.0 * area > 1e-7 * longest * longest)) light.power = 0.0;
  return light;
}

std::vector<WeightedLight> collect_triangles(const Scene& scene, const FlatGeometry& geometry, int variant) {
  std::vector<WeightedLight> lights;
  for (const DrawItem& item : geometry.items) {
    const Material* material = material_of_item(scene, item, variant);
    if (item.node >= 0 && !scene.nodes[static_cast<std::size_t>(item.node)].visible) continue;
    if (!material || !(luminance(glm::dvec3(material->emissive)) > 0.0)) continue;
    for (std::uint32_t k = 0; k + 2 < item.index_count; k += 3) {
      WeightedLight light = make_triangle(scene, geometry, *material, geometry.indices.data() + item.first_index + k);
      light.triangle = (item.first_index + k) / 3;
      if (light.power > 0.0 && std::isfinite(light.power)) lights.push_back(light);
    }
  }
  return lights;
}

/// Radius of the bounding sphere of all finite positions.
double scene_radius(const FlatGeometry& geometry) {
  glm::dvec3 low(1e300);
  glm::dvec3 high(-1e300);
  for (const glm::vec3& p : geometry.positions) {
    if (!is_finite(glm::dvec3(p))) continue;
    low = glm::min(low, glm::dvec3(p));
    high = glm::max(high, glm::dvec3(p));
  }
  return low.x <= high.x ? 0.5 * glm::length(high - low) : 1.0;
}

WeightedLight make_punctual(const PunctualLight& light, const glm::mat4& world_from_node, double radius) {
  const glm::dmat4 world(world_from_node);
  const glm::dvec3 position(world * glm::dvec4(0.0, 0.0, 0.0, 1.0));
  const glm::dvec3 axis(world * glm::dvec4(0.0, 0.0, -1.0, 0.0));  // KHR_lights_punctual: along -z of the node
  const glm::dvec3 color = glm::dvec3(light.color) * static_cast<double>(light.intensity);
  WeightedLight out;
  const double length = glm::length(axis);
  const double y = luminance(color);
  if (!is_finite(position) || !is_finite(color) || !std::isfinite(length) || !(y > 0.0)) return out;
  if (light.kind != PunctualLight::Kind::point && !(length > 0.0)) return out;
  out.record.position = glm::vec3(position);
  out.record.direction = length > 0.0 ? glm::vec3(axis / length) : glm::vec3(0.0f, -1.0f, 0.0f);
  out.record.color = glm::vec3(color);
  out.record.range_m = std::isfinite(light.range_m) ? std::max(light.range_m, 0.0f) : 0.0f;
  switch (light.kind) {
    case PunctualLight::Kind::directional:
      out.record.kind = shared::kLightDirectional;
      out.power = y * std::numbers::pi * radius * radius;
      break;
    case PunctualLight::Kind::point:
      out.record.kind = shared::kLightPoint;
      out.power = y * 4.0 * std::numbers::pi;
      break;
    case PunctualLight::Kind::spot: {
      const double outer = std::clamp(static_cast<double>(light.outer_cone_rad), 0.0, 0.5 * std::numbers::pi);
      const double inner = std::clamp(static_cast<double>(light.inner_cone_rad), 0.0, outer);
      out.record.kind = shared::kLightSpot;
      out.record.edge2 = glm::vec3(std::cos(inner), std::cos(outer), 0.0);
      // Integral of the squared linear ramp in cos: a third of the penumbra.
      out.power = y * 2.0 * std::numbers::pi * (1.0 - std::cos(inner) + (std::cos(inner) - std::cos(outer)) / 3.0);
      break;
    }
  }
  return out;
}

void keep_strongest(std::vector<WeightedLight>* lights, std::size_t count) {
  std::stable_sort(lights->begin(), lights->end(),
                   [](const WeightedLight& a, const WeightedLight& b) { return a.power > b.power; });
  if (lights->size() > count) lights->resize(count);
}

double total_power(const std::vector<WeightedLight>& lights) {
  return std::accumulate(lights.begin(), lights.end(), 0.0,
                         [](double sum, const WeightedLight& light) { return sum + light.power; });
}

void set_probabilities(std::vector<WeightedLight>* lights) {
  std::vector<double> powers;
  for (const WeightedLight& light : *lights) powers.push_back(light.power);
  const std::vector<float> cdf = cumulative_in_steps(powers);
  for (std::size_t i = 0; i < cdf.size(); ++i) {
    (*lights)[i].record.selection_pdf = cdf[i] - (i > 0 ? cdf[i - 1] : 0.0f);
    (*lights)[i].record.cdf = cdf[i];
  }
}

}  // namespace

std::vector<float> cumulative_in_steps(const std::vector<double>& weights) {
  constexpr double kSteps = 16777216.0;
  if (weights.empty()) return {};
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  double left = kSteps;
  std::vector<double> steps;
  for (const double weight : weights) {
    steps.push_back(std::max(std::round(weight / sum * kSteps), 1.0));
    left -= steps.back();
  }
  const auto strongest = std::max_element(steps.begin(), steps.end());
  *strongest = std::max(*strongest + left, 1.0);
  double cumulative = 0.0;
  std::vector<float> cdf;
  for (const double step : steps) cdf.push_back(static_cast<float>(std::min((cumulative += step) / kSteps, 1.0)));
  cdf.back() = 1.0f;
  return cdf;
}

LightList build_light_list(const Scene& scene, const FlatGeometry& geometry, int variant, int max_triangles) {
  std::vector<WeightedLight> lights;
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  const double radius = scene_radius(geometry);
  for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
    const Node& node = scene.nodes[n];
    if (!node.visible || node.light < 0 || node.light >= static_cast<int>(scene.lights.size())) continue;
    const WeightedLight light = make_punctual(scene.lights[static_cast<std::size_t>(node.light)], world[n], radius);
    if (light.power > 0.0 && std::isfinite(light.power)) lights.push_back(light);
  }
  std::vector<WeightedLight> triangles = collect_triangles(scene, geometry, variant);
  const double all = total_power(lights) + total_power(triangles);
  keep_strongest(&triangles, static_cast<std::size_t>(std::max(max_triangles, 0)));
  lights.insert(lights.end(), triangles.begin(), triangles.end());
  LightList list;
  list.diagonal_m = 2.0 * radius;
  list.dropped_power = all > 0.0 ? std::max(1.0 - total_power(lights) / all, 0.0) : 0.0;
  if (list.dropped_power < 1e-12) list.dropped_power = 0.0;
  set_probabilities(&lights);
  for (const WeightedLight& light : lights) {
    list.lights.push_back(light.record);
    list.triangles.push_back(light.triangle);
  }
  return list;
}

}  // namespace maquette
