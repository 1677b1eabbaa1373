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
  return {shared::intersect_plane_of_triangle(d.origin_x, d.direction_x, p0, e1, e2).barycentric - b,
          shared::intersect_plane_of_triangle(d.origin_y, d.direction_y, p0, e1, e2).barycentric - b};
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

  /// Of the triangle, by the coordinates of one texture.
  glm::vec4 tangent(int texture, const glm::vec3& normal, const TracedTriangle& t, const glm::vec4& otherwise) const {
    shared::TextureFilter filter{scene_.atlas};
    const bool second = (static_cast<int>(filter.texture_record(texture, 2).w) & 2) != 0;
    const std::vector<glm::vec2>& set = second ? scene_.geometry.uv1 : scene_.geometry.uv0;
    const auto along = [&](int k) {
      return filter.texture_transformed(texture, set[corners_.index[k]] - set[corners_.index[0]]);
    };
    return shared::triangle_tangent(normal, t.positions[1] - t.positions[0], t.positions[2] - t.positions[0], along(1),
                                    along(2), otherwise);
  }

 private:
  const PathScene& scene_;
  Corners corners_;
  Footprint footprint_;
};

/// Factors of the material after its textures.
struct Factors {
  glm::vec3 base_color{}, emission{};
  float metallic, roughness, clearcoat, clearcoat_roughness, specular;
  glm::vec3 specular_color{}, sheen_color{};
  float sheen_roughness, occlusion, pane, thickness, anisotropy, film, film_nm;
  glm::vec2 along{};                  ///< direction of the anisotropy in the tangent plane
  glm::vec3 mapped{}, coat_mapped{};  ///< normals of the textures

  Factors(const TracedMaterial& m, const glm::vec3& color)
      : base_color(color),
        emission(m.values.emissive),
        metallic(m.values.metallic),
        roughness(m.values.roughness),
        clearcoat(m.values.clearcoat),
        clearcoat_roughness(m.values.clearcoat_roughness),
        specular(m.values.specular),
        specular_color(m.values.specular_color),
        sheen_color(m.values.sheen_color),
        sheen_roughness(m.values.sheen_roughness),
        occlusion(1.0f),
        pane(m.pane),
        thickness(1.0f),
        anisotropy(m.values.anisotropy),
        film(m.values.iridescence),
        film_nm(m.values.iridescence_greatest_nm),
        along(std::cos(m.values.anisotropy_rotation_rad), std::sin(m.values.anisotropy_rotation_rad)),
        mapped(0.0f, 0.0f, 1.0f),
        coat_mapped(0.0f, 0.0f, 1.0f) {}
};

/// Applies textures to the factors of one material.
class FactorReader {
 public:
  FactorReader(const TracedMaterial& m, const TextureReader& reader, Factors* factors)
      : material_(m), reader_(reader), f_(*factors) {}

  void read() {
    const Material& v = material_.values;
    if (!material_.tabulated() || v.tint_measured) times(TextureRole::base_color, &f_.base_color);
    times(TextureRole::emissive, &f_.emission);
    if (has(TextureRole::occlusion))
      f_.occlusion = glm::mix(1.0f, value(TextureRole::occlusion).x, v.occlusion_strength);
    if (has(TextureRole::transmission)) f_.pane *= value(TextureRole::transmission).x;
    times(TextureRole::thickness, 1, &f_.thickness);
    f_.mapped = normal(TextureRole::normal);
    if (!material_.tabulated()) read_lobes();
    if (has(TextureRole::metallic_roughness) && v.transmission > 0.0f) f_.pane *= 1.0f - f_.metallic;
  }

 private:
  bool has(TextureRole role) const { return material_.texture(role) >= 0; }
  glm::vec4 value(TextureRole role) const { return reader_.read(material_.texture(role)); }
  void times(TextureRole role, glm::vec3* factor) const {
    if (has(role)) *factor *= glm::vec3(value(role));
  }
  void times(TextureRole role, int channel, float* factor) const {
    if (has(role)) *factor *= value(role)[channel];
  }
  glm::vec3 normal(TextureRole role) const {
    return has(role) ? glm::vec3(value(role)) * 2.0f - 1.0f : glm::vec3(0.0f, 0.0f, 1.0f);
  }

  void read_lobes() {
    const Material& v = material_.values;
    times(TextureRole::metallic_roughness, 2, &f_.metallic);
    times(TextureRole::metallic_roughness, 1, &f_.roughness);
    times(TextureRole::clearcoat, 0, &f_.clearcoat);
    times(TextureRole::clearcoat_roughness, 1, &f_.clearcoat_roughness);
    f_.coat_mapped = normal(TextureRole::clearcoat_normal);
    times(TextureRole::specular, 3, &f_.specular);
    times(TextureRole::specular_color, &f_.specular_color);
    times(TextureRole::sheen_color, &f_.sheen_color);
    times(TextureRole::sheen_roughness, 3, &f_.sheen_roughness);
    times(TextureRole::iridescence, 0, &f_.film);
    if (has(TextureRole::iridescence_thickness))
      f_.film_nm = glm::mix(v.iridescence_least_nm, f_.film_nm, value(TextureRole::iridescence_thickness).y);
    if (!has(TextureRole::anisotropy)) return;
    const glm::vec4 texel = value(TextureRole::anisotropy);
    const glm::vec2 a = glm::vec2(texel) * 2.0f - 1.0f;
    const glm::vec2 turn = glm::dot(a, a) > 1e-4f ? glm::normalize(a) : glm::vec2(1.0f, 0.0f);
    f_.along = {turn.x * f_.along.x - turn.y * f_.along.y, turn.x * f_.along.y + turn.y * f_.along.x};
    f_.anisotropy *= texel.z;
  }

  const TracedMaterial& material_;
  const TextureReader& reader_;
  Factors& f_;
};

/// Where the BTF is read, its frame, and what directions are drawn by: the cosine alone.
void place_btf(const PathScene& scene, const Corners& c, const RayHit& hit, const RayDifferential* differential,
               const glm::vec3& outward, SurfacePoint* p) {
  const TracedTriangle& corner = scene.triangles[hit.triangle];
  const glm::vec4 tangent = c.mix(scene.geometry.tangents);
  p->t = glm::normalize(shared::tangent_direction(p->n, tangent, glm::vec2(1.0f, 0.0f)));
  const glm::vec3 up = shared::tangent_direction(outward, tangent, glm::vec2(0.0f, 1.0f));
  p->b = glm::cross(p->n, p->t);
  if (glm::dot(p->b, up) < 0.0f) p->b = -p->b;  // mirrored coordinates, or seen from behind
  p->analytic = shared::make_analytic(glm::vec3(0.5f), 0.0f, 1.0f, 1.5f, 0.0f, glm::vec3(0.0f), 0.0f, 0.0f,
                                      glm::vec3(0.0f), 0.0f);
  p->lobe_weights = glm::vec3(1.0f, 0.0f, 0.0f);
  const Btf& btf = *p->material->btf;
  const float side = scene.metres_per_uv[corner.source];
  if (!(side > 0.0f)) {
    p->btf = {glm::vec2(0.5f), 1.0f};  // no coordinates: its mean
    return;
  }
  const glm::vec2 tiles = side / glm::vec2(btf.width_m(), btf.height_m());
  const std::vector<glm::vec2>& set = scene.geometry.uv0;
  p->btf = {c.mix(set) * tiles, 0.0f};
  if (!differential) return;
  const auto& [p0, p1, p2] = corner.positions;
  const Footprint f = footprint_of(*differential, p0, p1 - p0, p2 - p0, hit.barycentric);
  const glm::vec2 a1 = set[c.index[1]] - set[c.index[0]], a2 = set[c.index[2]] - set[c.index[0]];
  const auto length_along = [&](const glm::vec2& d) { return glm::length((a1 * d.x + a2 * d.y) * tiles); };
  p->btf.footprint = std::max(length_along(f.dx), length_along(f.dy));
}

/// `coat_normal`: world, unit; null where it is that of the base.
void fill_material(const TracedMaterial& m, const Factors& f, const glm::vec3* coat_normal, SurfacePoint* p) {
  p->base_color = f.base_color;
  p->occlusion = f.occlusion;
  p->pane = f.pane;
  p->thickness = f.thickness;
  const Material& v = m.values;
  if (f.pane > 0.0f) p->faces = shared::pane_faces(v.ior, f.specular, f.specular_color);
  if (m.tabulated()) {
    p->tint = v.tint_measured ? f.base_color : glm::vec3(1.0f);
    return;
  }
  p->analytic = shared::make_analytic(f.base_color, f.metallic, f.roughness, v.ior, f.specular, f.specular_color,
                                      f.clearcoat, f.clearcoat_roughness, f.sheen_color, f.sheen_roughness);
  if (f.anisotropy > 0.0f) p->analytic = shared::with_anisotropy(p->analytic, f.anisotropy);
  if (f.clearcoat > 0.0f && coat_normal) p->analytic.coat_normal = p->to_local(*coat_normal);
  p->analytic.film = f.film_nm > 0.0f ? f.film : 0.0f;
  p->analytic.film_ior = v.iridescence_ior;
  p->analytic.film_nm = f.film_nm;
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
  Factors f(m, plain_color(scene, m, c));
  const glm::vec3 smooth = interpolated_unit_normal(corner, c);
  glm::vec3 normal = smooth, coat_normal = smooth;
  if (m.textured) {
    const Footprint footprint =
        options.differential ? footprint_of(*options.differential, p0, p1 - p0, p2 - p0, hit.barycentric) : Footprint();
    const TextureReader reader(scene, c, footprint);
    FactorReader(m, reader, &f).read();
    const glm::vec4 tangent = c.mix(scene.geometry.tangents);
    if (m.texture(TextureRole::normal) >= 0)
      normal = shared::apply_normal_map(smooth, tangent, f.mapped, v.normal_scale);
    if (const int coat = m.texture(TextureRole::clearcoat_normal); coat >= 0) {
      const bool own = m.own_coat_tangents && std::abs(tangent.w) < 1.5f;
      coat_normal = shared::apply_normal_map(smooth, own ? reader.tangent(coat, smooth, corner, tangent) : tangent,
                                             f.coat_mapped, v.clearcoat_normal_scale);
    }
  }
  // Metal transmits nothing, and the surface besides the pane has all of it.
  if (f.pane > 0.0f && v.transmission > 0.0f) f.metallic = std::min(f.metallic / std::max(1.0f - f.pane, 1e-6f), 1.0f);
  p.n = shared::face_viewer(normal, p.normal, view);
  p.normal_adjusted = p.n != normal && p.n != -normal;
  const shared::TangentBasis basis = shared::tangent_basis(p.n);
  p.t = basis.t;
  p.b = basis.b;
  if (m.btf) {
    place_btf(scene, c, hit, options.differential, smooth, &p);
  } else if (f.anisotropy > 0.0f && !m.measured) {
    p.t = glm::normalize(shared::tangent_direction(p.n, c.mix(scene.geometry.tangents), f.along));
    p.b = glm::cross(p.n, p.t);
  }
  p.wo = local_view(p, view);
  const bool shines = p.front || (corner.material & kBothSides) != 0;
  const bool same = normal == coat_normal;
  coat_normal = shared::face_viewer(coat_normal, p.normal, view);
  p.emission = shines ? f.emission : glm::vec3(0.0f);
  if (!m.tabulated()) p.emission *= shared::emission_through_coat(f.clearcoat, glm::dot(coat_normal, view));
  fill_material(m, f, same ? nullptr : &coat_normal, &p);
}

PaneShares shares_of_pane(float cosine, const shared::PaneFaces& faces, const glm::vec3& inside) {
  if (!shared::is_plain(faces)) return shared::pane_shares(cosine, faces, inside);
  PaneShares shares{};
  for (int c = 0; c < 3; ++c) {
    if (c > 0 && inside[c] == inside[c - 1]) {
      shares.reflected[c] = shares.reflected[c - 1];
      shares.transmitted[c] = shares.transmitted[c - 1];
      continue;
    }
    const glm::vec2 pane = shared::fresnel_pane(cosine, faces.index.x, inside[c]);
    shares.reflected[c] = pane.x;
    shares.transmitted[c] = pane.y;
  }
  return shares;
}

PaneRays rays_of_pane(const SurfacePoint& p, const Ray& ray) {
  PaneRays rays;
  rays.shares = shares_of_pane(p.wo.z, p.faces, glm::clamp(p.base_color, 0.0f, 1.0f));
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
  const TextureReader reader(scene, c, Footprint());
  glm::vec3 inside = plain_color(scene, m, c);
  if (m.texture(TextureRole::base_color) >= 0) inside *= glm::vec3(reader.read(m.texture(TextureRole::base_color)));
  inside = glm::clamp(inside, 0.0f, 1.0f);
  float share = m.pane;
  if (m.texture(TextureRole::transmission) >= 0) share *= reader.read(m.texture(TextureRole::transmission)).x;
  if (m.texture(TextureRole::metallic_roughness) >= 0 && m.values.transmission > 0.0f)
    share *= 1.0f - m.values.metallic * reader.read(m.texture(TextureRole::metallic_roughness)).z;
  float specular = m.values.specular;
  glm::vec3 specular_color = m.values.specular_color;
  if (m.texture(TextureRole::specular) >= 0) specular *= reader.read(m.texture(TextureRole::specular)).w;
  if (m.texture(TextureRole::specular_color) >= 0)
    specular_color *= glm::vec3(reader.read(m.texture(TextureRole::specular_color)));
  return shares_of_pane(cosine, shared::pane_faces(m.values.ior, specular, specular_color), inside).transmitted * share;
}

float alpha_at(const PathScene& scene, std::uint32_t triangle, const glm::vec2& barycentric,
               const RayDifferential& differential) {
  const TracedMaterial& m = scene.material_of(triangle);
  const Corners c = corners_of(scene, triangle, barycentric);
  float alpha = m.values.base_color.a;
  if (m.colored) alpha *= c.mix(scene.geometry.colors).w;
  const int texture = m.texture(TextureRole::base_color);
  if (texture < 0) return alpha;
  const auto& [p0, p1, p2] = scene.triangles[triangle].positions;
  const Footprint footprint = footprint_of(differential, p0, p1 - p0, p2 - p0, barycentric);
  return alpha * TextureReader(scene, c, footprint).read(texture).w;
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
  glm::vec3 result{};
  for (int c = 0; c < 3; ++c) result[c] = next_float(moved[c], (normal[c] > 0.0f ? 1 : 0) - (normal[c] < 0.0f ? 1 : 0));
  return result;
}

}  // namespace maquette
