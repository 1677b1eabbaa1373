#include "render/reference/light_sampling.h"

#include <algorithm>
#include <cmath>

#include "render/lights/triangle_view.h"
#include "render/reference/presampled_environment.h"
#include "render/reference/surface.h"

namespace maquette {

namespace {

constexpr float kEndless = 3.4e38f;

/// 1/sr, within float's range.
float density_of(const TriangleView& view) { return static_cast<float>(1.0 / std::max(view.solid_angle(), 1e-30)); }

}  // namespace

EnvironmentLight::EnvironmentLight(const TracedEnvironment& environment, const PathOptions& options, LightGuide* guide,
                                   const PresampledEnvironment* samples)
    : environment_(environment),
      cosine_(std::cos(options.env_rotation_rad)),
      sine_(std::sin(options.env_rotation_rad)),
      scale_(options.env_scale),
      mean_lux_(0.25f * options.env_scale * static_cast<float>(environment.tables.luminance_integral)),
      guide_(guide),
      samples_(samples) {}

std::uint32_t EnvironmentLight::cell_of(const glm::vec3& position, const glm::vec3& normal) const {
  return guide_ ? guide_->cell_of(position, normal) : LightGuide::kNoCell;
}

void EnvironmentLight::compute_shares(std::uint32_t cell, const glm::vec3& normal, LeafShares* shares) const {
  guide_->compute_shares(cell, shared::latlong_rotate(normal, cosine_, -sine_), shares);
}

glm::vec4 EnvironmentLight::radiance_and_density(const glm::vec3& world, const LeafShares* shares) const {
  const glm::vec3 own = shared::latlong_rotate(world, cosine_, -sine_);
  const EnvironmentLookup found = environment_.look_up(own);
  const auto texel = static_cast<std::size_t>(found.y * environment_.tables.width + found.x);
  const float gain = shares ? guide_->gain(*shares, environment_.partition->leaf_at(found.x, found.y)) : 1.0f;
  return {found.radiance * scale_, environment_.density_at(texel, own) * gain};
}

LightDraw EnvironmentLight::draw(const glm::vec2& u) const {
  return draw_at(sample_environment_point(environment_.tables, u.x, u.y), -1);
}

LightDraw EnvironmentLight::draw_in_leaf(int leaf, const glm::vec2& within) const {
  return draw_at(environment_.partition->sample(environment_.tables, leaf, within.x, within.y), leaf);
}

LightDraw EnvironmentLight::draw_at(const EnvironmentPoint& drawn, int leaf) const {
  const EnvironmentPoint point = environment_.follow_light(drawn);
  LightDraw draw;
  draw.distance = kEndless;
  draw.leaf = leaf;
  draw.direction = shared::latlong_rotate(environment_.partition->direction(point), cosine_, sine_);
  draw.texel = static_cast<int>(point.row) * environment_.tables.width + static_cast<int>(point.x);
  return draw;
}

void EnvironmentLight::choose_directions(const PathSampler::Pairs& numbers, std::uint32_t cell,
                                         const LeafShares* shares, std::uint32_t path,
                                         std::span<Choice> choices) const {
  const bool records = shares && guide_->learning();
  const bool sampled = shares && samples_ && samples_->serves(path);
  for (std::size_t k = 0; k < choices.size(); ++k) {
    Choice& choice = choices[k];
    choice = {.within = numbers[k]};
    if (!shares) continue;
    const LeafShares::Choice chosen = shares->choose_leaf(choice.within.x);
    choice.leaf = chosen.leaf;
    choice.within.x = chosen.within;
    choice.gain = guide_->gain(chosen);
    if (records) guide_->prefetch_record(cell, chosen.leaf);
    if (!sampled) continue;
    choice.sample = &samples_->at(path, chosen.leaf, choice.within);
    __builtin_prefetch(choice.sample);
  }
}

void EnvironmentLight::draw_chosen(const Choice& choice, LightDraw* out) const {
  if (!choice.sample) {
    *out = choice.leaf < 0 ? draw(choice.within) : draw_in_leaf(choice.leaf, choice.within);
    return;
  }
  out->direction = choice.sample->direction;
  out->distance = kEndless;
  out->radiance = choice.sample->radiance;
  out->pdf = choice.sample->density * choice.gain;
  out->has_extent = true;
  out->texel = -1;
  out->leaf = choice.leaf;
}

void EnvironmentLight::fill(LightDraw* draw, const LeafShares* shares) const {
  const glm::vec3 own = shared::latlong_rotate(draw->direction, cosine_, -sine_);
  draw->radiance = environment_.look_up(own).radiance * scale_;
  draw->pdf = environment_.density_at(static_cast<std::size_t>(draw->texel), own);
  if (shares) draw->pdf *= guide_->gain(*shares, draw->leaf);
}

void EnvironmentLight::record(int leaf, std::uint32_t cell, float useful) const {
  if (cell != LightGuide::kNoCell && guide_->learning()) guide_->record(cell, leaf, useful);
}

void prefetch_scene_light(const PathScene& scene, const LightPick& pick) {
  __builtin_prefetch(&scene.lights.lights[pick.index]);
  if (const std::uint32_t triangle = scene.light_triangles[pick.index]; triangle != kNoTriangle)
    __builtin_prefetch(&scene.triangles[triangle].material);
}

LightDraw draw_scene_light(const PathScene& scene, const glm::vec3& position, const LightPick& pick, const glm::vec2& u,
                           bool mean_emission) {
  const LightRecord& light = scene.lights.lights[pick.index];
  LightDraw draw;
  draw.has_extent = light.kind == shared::kLightTriangle;
  if (!draw.has_extent) {
    const shared::LightSample s = shared::light_sample(light, position, u);
    draw.direction = s.wi;
    draw.distance = s.distance_m;
    draw.radiance = s.radiance;
    draw.pdf = pick.probability;
    return draw;
  }
  const TriangleView view(light, position);
  if (!(view.solid_angle() > 0.0)) return draw;
  const TriangleView::Sample s = view.sample(u);
  draw.direction = s.wi;
  draw.distance = s.distance_m;
  draw.pdf = pick.probability * density_of(view);
  draw.radiance = light.color;
  const std::uint32_t triangle = scene.light_triangles[pick.index];
  if (!mean_emission && scene.material_of(triangle).texture(TextureRole::emissive) >= 0)
    draw.radiance = emission_at(scene, triangle, s.uv);
  return draw;
}

float scene_light_pdf(const PathScene& scene, std::uint32_t triangle, const glm::vec3& from) {
  if (scene.triangle_light.empty() || scene.triangle_light[triangle] == kNoTriangle) return 0.0f;
  const std::uint32_t index = scene.triangle_light[triangle];
  const TriangleView view(scene.lights.lights[index], from);
  if (!(view.solid_angle() > 0.0)) return 0.0f;
  return light_probability(scene.lights, light_cell(scene.lights, from), index) * density_of(view);
}

}  // namespace maquette
