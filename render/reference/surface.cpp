#include "render/reference/surface.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace maquette {

namespace {

/// Rounding error of position = sum of b_i p_i and of the ray tracer's plane test, relative to the sum of
///
/// b_i p_i
///
/// : 16 half units in the last place. Source: Pharr et al. 2023, Sec. 6.8.5 has 7 for the sum alone; the rest is for
/// the test, which subtracts coordinates of the same size.
constexpr float kPositionError = 16.0f * 0x1p-24f;

/// std::nextafter of a finite number, upwards (step 1), downwards (-1) or not at all (0), without calls and branches.
float next_float(float value, std::int32_t step) {
  const auto bits = std::bit_cast<std::int32_t>(value);
  // These integers have the order of the floats; both zeros map to the same integer.
  const std::int32_t sign = bits >> 31;
  const std::int32_t next = (((bits & 0x7fffffff) ^ sign) - sign) + step;
  const std::int32_t next_sign = next >> 31;
  return std::bit_cast<float>(((next ^ next_sign) - next_sign) |
                              (next_sign & std::numeric_limits<std::int32_t>::min()));
}

/// Corner values of one triangle, and their interpolation.
struct Corners {
  const std::uint32_t* index;
  float b0, b1, b2;
  template <typename T>
  T mix(const std::vector<T>& values) const {
    return values[index[0]] * b0 + values[index[1]] * b1 + values[index[2]] * b2;
  }
};

Corners corners_of(const PathScene& scene, std::uint32_t triangle, const glm::vec2& b) {
  return {scene.corners(triangle), 1.0f - b.x - b.y, b.x, b.y};
}

struct Footprint {
  glm::vec2 dx{0.0f}, dy{0.0f};  ///< barycentric coordinates at the neighbouring pixels less those here
};

Footprint footprint_of(const RayDifferential& d, const glm::vec3& p0, const glm::vec3& e1, const glm::vec3& e2,
                       const glm::vec2& b) {
  return {shared::intersect_plane_of_triangle(d.origin, d.direction_x, p0, e1, e2).barycentric - b,
          shared::intersect_plane_of_triangle(d.origin, d.direction_y, p0, e1, e2).barycentric - b};
}

/// Reads the textures of one hit.
class TextureReader {
 public:
  TextureReader(const PathScene& scene, const Corners& corners, const Footprint& footprint)
      : scene_(scene), corners_(corners), footprint_(footprint) {}

  glm::vec4 read(int texture) const {
    shared::TextureFilter filter{scene_.atlas};
    const bool second = (static_cast<int>(filter.texture_record(texture, 2).w) & 2) != 0;
    const std::vector<glm::vec2>& set = second ? scene_.geometry.uv1 : scene_.geometry.uv0;
    const glm::vec2 uv = corners_.mix(set);
    const glm::vec2 a1 = set[corners_.index[1]] - set[corners_.index[0]];
    const glm::vec2 a2 = set[corners_.index[2]] - set[corners_.index[0]];
    const auto along = [&](const glm::vec2& d) { return filter.texture_transformed(texture, a1 * d.x + a2 * d.y); };
    return filter.sample_texture(texture, filter.texture_coordinates(texture, uv, uv), along(footprint_.dx),
                                 along(footprint_.dy));
  }

 private:
  const PathScene& scene_;
  Corners corners_;
  Footprint footprint_;
};

/// Factors of the material after its textures.
struct Factors {
  glm::vec3 base_color, emission;
  float metallic, roughness, clearcoat;
  glm::vec3 mapped{0.0f, 0.0f, 1.0f};
  bool has_normal_map = false;
};

Factors read_textures(const TracedMaterial& m, const TextureReader& reader, bool occlusion, Factors f) {
  const bool measured = m.measured != nullptr;
  const auto read = [&](TextureRole role) { return reader.read(m.texture(role)); };
  const auto has = [&](TextureRole role) { return m.texture(role) >= 0; };
  if (has(TextureRole::base_color) && (!measured || m.values.tint_measured))
    f.base_color *= glm::vec3(read(TextureRole::base_color));
  if (has(TextureRole::occlusion) && occlusion)
    f.base_color *= glm::mix(1.0f, read(TextureRole::occlusion).x, m.values.occlusion_strength);
  if (has(TextureRole::metallic_roughness) && !measured) {
    const glm::vec4 value = read(TextureRole::metallic_roughness);
    f.metallic *= value.z;
    f.roughness *= value.y;
  }
  if (has(TextureRole::clearcoat) && !measured) f.clearcoat *= read(TextureRole::clearcoat).x;
  if (has(TextureRole::emissive)) f.emission *= glm::vec3(read(TextureRole::emissive));
  f.has_normal_map = has(TextureRole::normal);
  if (f.has_normal_map) f.mapped = glm::vec3(read(TextureRole::normal)) * 2.0f - 1.0f;
  return f;
}

void fill_material(const TracedMaterial& m, const Factors& f, SurfacePoint* p) {
  p->base_color = f.base_color;
  const Material& v = m.values;
  if (m.measured) {
    p->tint = v.tint_measured ? f.base_color : glm::vec3(1.0f);
    return;
  }
  p->analytic = shared::make_analytic(f.base_color, f.metallic, f.roughness, v.ior, v.specular, v.specular_color,
                                      f.clearcoat, v.clearcoat_roughness, v.sheen_color, v.sheen_roughness);
  p->lobe_weights = shared::analytic_lobe_weights(p->analytic, p->wo);
}

/// As in shaders/shading/point.glsl: never quite below the horizon.
glm::vec3 local_view(const SurfacePoint& p, const glm::vec3& view) {
  glm::vec3 wo = p.to_local(view);
  wo.z = std::max(wo.z, 1e-3f);
  return glm::normalize(wo);
}

glm::vec3 interpolated_unit_normal(const TracedTriangle& t, const Corners& c) {
  return shared::interpolated_normal(t.normals[0] * c.b0 + t.normals[1] * c.b1 + t.normals[2] * c.b2, t.geometric);
}

/// Base colour before textures.
glm::vec3 plain_color(const PathScene& scene, const TracedMaterial& m, const Corners& c) {
  const glm::vec3 color(m.values.base_color);
  return m.colored ? color * glm::vec3(c.mix(scene.geometry.colors)) : color;
}

}  // namespace

void resolve_surface(const PathScene& scene, const Ray& ray, const RayHit& hit, const SurfaceOptions& options,
                     SurfacePoint* out) {
  const Corners c = corners_of(scene, hit.triangle, hit.barycentric);
  const TracedTriangle& corner = scene.triangles[hit.triangle];
  const auto& [p0, p1, p2] = corner.positions;
  SurfacePoint& p = *out;
  p.triangle = hit.triangle;
  p.material = &scene.material_of(hit.triangle);
  p.position = p0 * c.b0 + p1 * c.b1 + p2 * c.b2;
  // The largest coordinate bounds all three, because the ray tracer's test mixes them. On the plane y = 0 the sum for y
  // alone is 0, and every ray from a floor of triangles below a centimetre hit that floor.
  const glm::vec3 magnitude = glm::abs(p0 * c.b0) + glm::abs(p1 * c.b1) + glm::abs(p2 * c.b2);
  p.error = glm::vec3(shared::light_largest(magnitude) * kPositionError);
  const glm::vec3 view = -glm::normalize(ray.direction);
  p.front = glm::dot(corner.geometric, view) >= 0.0f;
  p.normal = p.front ? corner.geometric : -corner.geometric;

  const TracedMaterial& m = *p.material;
  const Material& v = m.values;
  Factors f{.base_color = plain_color(scene, m, c),
            .emission = v.emissive,
            .metallic = v.metallic,
            .roughness = v.roughness,
            .clearcoat = v.clearcoat};
  glm::vec3 normal = interpolated_unit_normal(corner, c);
  if (m.textured) {
    const Footprint footprint =
        options.differential ? footprint_of(*options.differential, p0, p1 - p0, p2 - p0, hit.barycentric) : Footprint();
    f = read_textures(m, TextureReader(scene, c, footprint), options.occlusion_texture, f);
    if (f.has_normal_map)
      normal = shared::apply_normal_map(normal, c.mix(scene.geometry.tangents), f.mapped, v.normal_scale);
  }
  p.n = shared::face_viewer(normal, p.normal, view);
  p.normal_adjusted = p.n != normal && p.n != -normal;
  const shared::TangentBasis basis = shared::tangent_basis(p.n);
  p.t = basis.t;
  p.b = basis.b;
  p.wo = local_view(p, view);
  const bool shines = p.front || (corner.material & kBothSides) != 0;
  p.emission = shines ? f.emission : glm::vec3(0.0f);
  fill_material(m, f, &p);
}

PaneShares pane_shares(float cosine, float ior, const glm::vec3& inside) {
  PaneShares shares;
  for (int c = 0; c < 3; ++c) {
    if (c > 0 && inside[c] == inside[c - 1]) {
      shares.reflected[c] = shares.reflected[c - 1];
      shares.transmitted[c] = shares.transmitted[c - 1];
      continue;
    }
    const glm::vec2 pane = shared::fresnel_pane(cosine, std::max(ior, 1.0f), inside[c]);
    shares.reflected[c] = pane.x;
    shares.transmitted[c] = pane.y;
  }
  return shares;
}

PaneRays rays_of_pane(const SurfacePoint& p, const Ray& ray) {
  PaneRays rays;
  rays.shares = pane_shares(p.wo.z, p.material->values.ior, glm::clamp(p.base_color, 0.0f, 1.0f));
  rays.mirrored.origin = offset_from_surface(p.position, p.error, p.normal);
  rays.mirrored.direction = p.to_world({-p.wo.x, -p.wo.y, p.wo.z});
  // The shading normal reflects it below the geometric surface: it would leave through the pane.
  if (glm::dot(rays.mirrored.direction, p.normal) <= 0.0f) rays.shares.reflected = glm::vec3(0.0f);
  rays.passed.origin = offset_from_surface(p.position, p.error, -p.normal);
  rays.passed.direction = ray.direction;
  return rays;
}

glm::vec3 pane_transmittance(const PathScene& scene, std::uint32_t triangle, const glm::vec2& barycentric,
                             const glm::vec3& view) {
  const TracedMaterial& m = scene.material_of(triangle);
  const Corners c = corners_of(scene, triangle, barycentric);
  const float cosine = std::abs(glm::dot(interpolated_unit_normal(scene.triangles[triangle], c), glm::normalize(view)));
  glm::vec3 inside = plain_color(scene, m, c);
  if (m.texture(TextureRole::base_color) >= 0)
    inside *= glm::vec3(TextureReader(scene, c, Footprint()).read(m.texture(TextureRole::base_color)));
  inside = glm::clamp(inside, 0.0f, 1.0f);
  const auto passes = [&](float channel) {
    return shared::fresnel_pane(cosine, std::max(m.values.ior, 1.0f), channel).y;
  };
  const float red = passes(inside.x), green = inside.y == inside.x ? red : passes(inside.y);
  return glm::vec3(red, green, inside.z == inside.y ? green : passes(inside.z)) * m.pane;
}

glm::vec3 emission_at(const PathScene& scene, std::uint32_t triangle, const glm::vec2& barycentric) {
  const TracedMaterial& m = scene.material_of(triangle);
  const int texture = m.texture(TextureRole::emissive);
  if (texture < 0) return m.values.emissive;
  return m.values.emissive *
         glm::vec3(TextureReader(scene, corners_of(scene, triangle, barycentric), Footprint()).read(texture));
}

glm::vec3 offset_from_surface(const glm::vec3& position, const glm::vec3& error, const glm::vec3& normal) {
  const glm::vec3 moved = position + normal * glm::dot(glm::abs(normal), error);
  glm::vec3 result;
  for (int c = 0; c < 3; ++c) result[c] = next_float(moved[c], (normal[c] > 0.0f ? 1 : 0) - (normal[c] < 0.0f ? 1 : 0));
  return result;
}

}  // namespace maquette
