#pragma once

// Full transport: unidirectional path tracing with next-event estimation. Source: Kajiya 1986; multiple importance
// sampling by the balance heuristic, Veach and Guibas 1995.
#include "render/reference/glass.h"
#include "render/reference/path.h"
#include "render/reference/path_constants.h"
#include "render/reference/path_sharing.h"
#include "render/reference/path_vertex.h"
#include "render/reference/scattering.h"

namespace maquette {

/// Traces one path from the surfaces of its camera ray, in steps. Each step prefetches what the next one reads; the
/// steps of other paths run in between.
class FullPath {
 public:
  FullPath(const PathScene& scene, const EnvironmentLight& environment, int max_bounces, const MirrorGuide* mirrors)
      : scene_(scene), environment_(environment), max_bounces_(max_bounces), mirrors_(mirrors) {}

  /// `shares`: exchanges light with the other paths of its tile.
  void begin(const CameraRay& ray, const PathSampler& sampler, bool shares) {
    camera_ray_ = &ray;
    sampler_ = sampler;
    result_ = {};
    in_tile_ = shares;
    reconnection_ = {};
    branches_ = 0;
    next_branch();
  }
  bool ended() const { return step_ == Step::none; }
  const PathEstimate& result() const { return result_; }
  /// What it exchanges with its tile, once it has ended.
  const Reconnection& reconnection() const { return reconnection_; }

  /// Traces to the next surface, or out of the scene.
  void trace() {
    if (step_ != Step::trace) return;
    ++result_.rays;
    if (intersect(scene_, ray_, RayKind::path, sampler_.word(dimension(kChance)), &hit_)) {
      const auto* triangle = reinterpret_cast<const char*>(&scene_.triangles[hit_.triangle]);
      __builtin_prefetch(triangle);
      __builtin_prefetch(triangle + 64);
      step_ = Step::resolve;
    } else {
      add_environment();
      next_branch();
    }
  }

  void resolve_hit() {
    if (step_ != Step::resolve) return;
    resolve_surface(scene_, ray_, hit_, {}, &hit_point_);
    point_ = &hit_point_;
    ++vertex_;
    if ((hit_point_.material->refracts() && pass_glass(hit_point_)) ||
        (hit_point_.material->clear() > 0.0f && pass_pane(hit_point_))) {
      continue_path(vertex_ < kMostPanes && largest_weight() > 0.0f);
      return;
    }
    add_emission(hit_point_);
    step_ = Step::scatter;
    if (reconnecting_ && bounce_ == 1 && vertex_ == 1) record_second_vertex(hit_point_);
    if (hit_point_.material->values.unlit) next_branch();
  }

  /// At a surface that scatters: finds grid cells and random numbers.
  void prepare_surface() {
    if (step_ != Step::scatter) return;
    const SurfacePoint& p = *point_;
    at_.shadow_rays = kShadowRays[static_cast<std::size_t>(std::min(bounce_, 2))];
    polarisation_ = {};
    locate(p);
    draw_numbers();
    at_.scattering = choose_scattering(p, at_.numbers[kMostShadowRays]);
  }

  /// Samples directions to the light sources, and the next direction of the path.
  void choose_directions() {
    if (step_ != Step::scatter) return;
    const SurfacePoint& p = *point_;
    set_mirror_share(p);
    set_lamp_rays();
    if (at_.has_lamp) {
      const std::uint32_t choice = dimension(kLightChoice);
      at_.picked = choose_light(scene_.lights, location().lamp_cell, sampler_.single(choice), sampler_.word(choice));
      prefetch_scene_light(scene_, at_.picked);
    }
    choose_environment(p);
    at_.drawn = bounce_ < max_bounces_ ? draw_direction(p, at_.scattering) : DrawnDirection();
    at_.query.wi = at_.drawn.wi;
  }

  /// Traces the shadow rays.
  void trace_shadow_rays() {
    if (step_ != Step::scatter) return;
    at_.arrived = 0;
    std::array<float, kMostShadowRays> useful;
    useful.fill(-1.0f);  // not traced
    for (std::uint32_t k = 0; k < at_.shadow_rays && !environment_.black(); ++k) {
      ShadowRay& light = at_.arriving[at_.arrived];
      environment_.draw_chosen(at_.choices[k], &light.draw);
      light.rays = static_cast<float>(at_.shadow_rays);
      light.choice = k;
      at_.arrived += trace_light(*point_, &light) ? 1 : 0;
      if (light.above) useful[k] = 0.0f;
    }
    const std::size_t of_sky = at_.arrived;
    LightDraw lamp;
    if (at_.has_lamp)
      lamp = draw_scene_light(scene_, point_->position, at_.picked, sampler_.pair(dimension(kLight)), false);
    if (lamp.pdf > 0.0f) {
      at_.arriving[at_.arrived].draw = lamp;
      at_.arriving[at_.arrived].rays = location().lamp_rays;
      at_.arrived += trace_light(*point_, &at_.arriving[at_.arrived]) ? 1 : 0;
    }
    // Panes and guide records of all rays together: one ray's data is fetched while another's is computed.
    std::size_t kept = 0;
    for (std::size_t i = 0; i < at_.arrived; ++i) {
      ShadowRay& light = at_.arriving[i];
      light.through = transmittance(scene_, light.draw.direction, light.passage);
      if (light.through == glm::vec3(0.0f)) continue;
      if (i < of_sky) useful[light.choice] = largest(light.through);
      if (kept != i) at_.arriving[kept] = light;
      ++kept;
    }
    at_.arrived = kept;
    for (std::uint32_t k = 0; k < at_.shadow_rays; ++k)
      if (useful[k] >= 0.0f) environment_.record(at_.choices[k].leaf, location().cell, useful[k]);
  }

  /// Queues the lookups in measured tables, together with those of other paths.
  void add_queries(QueryBatch* batch) {
    if (step_ != Step::scatter) return;
    for (std::size_t i = 0; i < at_.arrived; ++i) batch->add(*point_, &at_.arriving[i].query);
    if (at_.drawn.pdf > 0.0f) batch->add(*point_, &at_.query);
  }

  /// Adds the direct light and continues in the new direction.
  void scatter() {
    if (step_ != Step::scatter) return;
    if (reconnecting_) update_reconnection(*point_);
    for (std::size_t i = 0; i < at_.arrived; ++i) add_light(*point_, &at_.arriving[i]);
    continue_path(extend(*point_));
  }

 private:
  enum class Step { none, trace, resolve, scatter };

  void continue_path(bool further) {
    if (further)
      step_ = Step::trace;
    else
      next_branch();
  }

  /// Moves to the next surface of the camera ray that this path shades: the radiance from there along its wo counts.
  void next_branch() {
    while (branches_ < camera_ray_->surfaces_.size()) {
      const auto branch = static_cast<std::uint32_t>(branches_);
      const CameraRay::Surface& s = camera_ray_->surfaces_[branches_++];
      const float share = s.straight ? 1.0f : std::min(1.0f, kMirroredShare * largest(s.weight));
      if (share < 1.0f && sampler_.single(kDimensionsABranch * (64 + branch)) >= share) continue;
      base_ = 1 + kDimensionsABranch * branch;
      weight_.full = s.weight / share;
      weight_.shared = weight_.view_independent = glm::vec3(0.0f);
      reconnecting_ = in_tile_ && branch == 0 && s.straight;
      polarisation_ = {};
      bounce_ = vertex_ = 0;
      ray_ = {};
      ray_.direction = -s.point.to_world(s.point.wo);
      from_ = s.point.position;
      point_ = &s.point;
      step_ = Step::scatter;
      if (!s.point.material->refracts() || !pass_glass(s.point)) return;
      step_ = Step::trace;
      if (largest(weight_.full) > 0.0f) return;
    }
    step_ = Step::none;
  }

  std::uint32_t dimension(Dimension which) const {
    return base_ + static_cast<std::uint32_t>(std::min(vertex_, 255)) * kDimensionsASurface + which;
  }

  void add_environment() {
    if (environment_.black()) return;
    const glm::vec4 light = environment_.radiance_and_density(ray_.direction, shares());
    add(glm::vec3(light) * share_of(light.w * static_cast<float>(at_.shadow_rays)));
  }

  /// Adds arriving light. Most of it belongs to the reconnection, once there is one.
  void add(const glm::vec3& light) {
    result_.radiance += (weight_.full - reconnection_.carried * weight_.shared) * light;
    reconnection_.light += weight_.shared * light;
  }
  void scale(const glm::vec3& factor) {
    weight_.full *= factor;
    weight_.shared *= factor;
  }

  void record_second_vertex(const SurfacePoint& p) {
    if (!reconnection_.from || !shares_second(p, ray_.direction)) return;
    reconnection_.reached = true;
    reconnection_.carried = weight_.full;
    reconnection_.to = p.position;
    reconnection_.normal = p.normal;
    reconnection_.shading_normal = p.n;
  }

  /// Stores what the reconnection needs of the surface that the path is about to leave.
  void update_reconnection(const SurfacePoint& p) {
    weight_.view_independent = glm::vec3(0.0f);
    if (bounce_ == 0 && vertex_ == 0 && max_bounces_ > 0 && shares_first(p)) {
      reconnection_.from = &p;
      reconnection_.origin = location().origin;
      reconnection_.weight = weight_.full;
      reconnection_.mirror_cell = location().mirror_cell;
      reconnection_.mirror_share = at_.mirror_share;
      reconnection_.direction = p.to_world(at_.drawn.wi);
      reconnection_.pdf = at_.drawn.pdf;
    } else if (bounce_ == 1 && reconnection_.reached) {
      reconnection_.end = location().origin;
      weight_.view_independent = view_independent_brdf(p);
    }
  }

  /// Balance heuristic against the density `other` of shadow rays in this direction; none are sent behind a mirror.
  float share_of(float other) const { return pdf_ > 0.0f ? pdf_ / (pdf_ + other) : 1.0f; }

  void add_emission(const SurfacePoint& p) {
    if (p.material->values.unlit) add(p.base_color);
    if (p.emission == glm::vec3(0.0f)) return;
    const float other = pdf_ > 0.0f ? scene_light_pdf(scene_, p.triangle, scattered_at_) : 0.0f;
    add(p.emission * share_of(location().lamp_rays * other));
  }

  /// Reflects or transmits at a pane. False where this path treats it as a surface (the opaque share of the material).
  bool pass_pane(const SurfacePoint& p) {
    float u = sampler_.single(dimension(kPane));
    if (u >= p.pane) return false;
    u /= p.pane;
    add_emission(p);
    const PaneRays rays = rays_of_pane(p, ray_);
    const float reflect = largest(rays.shares.reflected), pass = largest(rays.shares.transmitted);
    float probability = reflect + pass > 0.0f ? reflect / (reflect + pass) : 0.0f;
    if (reflect > 0.0f) probability = std::max(probability, glm::mix(kLeastMirrored, kGuidedMirrored, at_.guided));
    if (u < probability) {
      scale(rays.shares.reflected / probability);
      ray_ = rays.mirrored;
      pdf_ = 0.0f;
    } else {
      scale(rays.shares.transmitted / (1.0f - probability));
      ray_ = rays.passed;
    }
    from_ = p.position;
    return true;
  }

  /// Solid or rough glass: reflects or transmits. Shadow rays do not find what is behind; a weight of 0 ends the path.
  /// False as in pass_pane.
  bool pass_glass(const SurfacePoint& p) {
    const TracedMaterial& m = *p.material;
    float u = sampler_.single(dimension(kPane));
    if (u >= p.pane) return false;
    u /= p.pane;
    if (m.solid && !p.front) scale(glm::exp(-m.absorption * glm::length(p.position - from_)));
    if (vertex_ > 0) add_emission(p);
    const float roughness = m.rough && !m.measured ? p.analytic.alpha : 0.0f;
    const GlassSample sample = sample_glass(p, glm::normalize(ray_.direction), roughness,
                                            sampler_.pair(dimension(kDirection)), u, &polarisation_);
    scale(sample.weight);
    ray_ = {offset_from_surface(p.position, p.error, sample.passed ? -p.normal : p.normal), sample.direction};
    from_ = p.position;
    pdf_ = 0.0f;
    return true;
  }

  /// Extends the path by the drawn direction; false where it ends.
  bool extend(const SurfacePoint& p) {
    if (!(at_.drawn.pdf > 0.0f)) return false;
    const glm::vec3 direction = p.to_world(at_.drawn.wi);
    if (glm::dot(direction, p.normal) <= 0.0f) return false;  // above the horizon of the shading normal only
    const glm::vec3 f = evaluate_brdf(p, at_.query);
    const float scale = at_.drawn.wi.z / at_.drawn.pdf;
    weight_.full *= f * scale;
    weight_.shared = (weight_.view_independent + weight_.shared * f) * scale;
    weight_.view_independent = glm::vec3(0.0f);
    if (!survives()) return false;
    ray_ = {location().origin, direction};
    pdf_ = at_.drawn.pdf;
    scattered_at_ = from_ = p.position;
    ++bounce_;
    return true;
  }

  /// Paths of one pixel follow each other, so most of them start at the location of the path before: it is kept.
  void locate(const SurfacePoint& p) {
    const bool first = branches_ == 1 && bounce_ == 0 && vertex_ == 0;
    at_.location = first ? 0 : 1;
    ShadingLocation& location = at_.locations[at_.location];
    if (first && p.position == location.position && p.error == location.error && p.normal == location.normal &&
        p.n == location.n)
      return;
    location.position = p.position;
    location.error = p.error;
    location.normal = p.normal;
    location.n = p.n;
    location.has_shares = false;
    location.origin = offset_from_surface(p.position, p.error, p.normal);
    find_cells(p, &location);
    location.lamp_rays = 0.0f;
    if (scene_.lights.lights.empty()) return;
    location.lamp_rays = kUnknown;
    location.lamp_cell = light_cell(scene_.lights, p.position);
    prefetch_cell(scene_.lights, location.lamp_cell);
  }

  /// Mean number of shadow rays to lamps there, and whether this path sends one.
  void set_lamp_rays() {
    ShadingLocation& location = at_.locations[at_.location];
    if (location.lamp_rays == kUnknown) {
      const float lux = scene_.lights.lux[location.lamp_cell], sky = environment_.known_lux(location.cell);
      location.lamp_rays = lux < sky ? std::max(lux / sky, kLeastLampRays) : 1.0f;
    }
    at_.has_lamp = location.lamp_rays >= 1.0f ||
                   (location.lamp_rays > 0.0f && sampler_.single(dimension(kChance)) < location.lamp_rays);
  }

  const ShadingLocation& location() const { return at_.locations[at_.location]; }

  /// Both guides use the same grid.
  void find_cells(const SurfacePoint& p, ShadingLocation* location) const {
    location->cell = environment_.cell_of(p.position, p.n);
    environment_.prefetch(location->cell);
    if (!mirrors_) return;
    location->mirror_cell = location->cell != LightGuide::kNoCell ? location->cell : mirrors_->cell_of(p.position, p.n);
    mirrors_->prefetch(location->mirror_cell);
  }

  /// Share of scattered rays that the guide of mirrored lamps draws: above 0 for diffuse lobes in cells that it knows.
  void set_mirror_share(const SurfacePoint& p) {
    at_.mirror_share = 0.0f;
    if (!mirrors_ || !mirrors_->has_light(location().mirror_cell)) return;
    mirrors_->prefetch_entries(location().mirror_cell);
    at_.mirror_share = kMirrorShare * (p.material->measured ? 1.0f : p.lobe_weights.x);
  }

  /// Density of draw_direction, given the BRDF's own.
  float mixed_pdf(float own, const glm::vec3& direction) const {
    return mirrors_ ? mirrors_->mixed_pdf(own, location().mirror_cell, at_.mirror_share, direction) : own;
  }

  DrawnDirection draw_direction(const SurfacePoint& p, const ScatteringChoice& choice) {
    at_.guided = 0.0f;
    if (!(at_.mirror_share > 0.0f)) return draw_scattering(p, choice);
    DrawnDirection s;
    if (sampler_.single(dimension(kGuide)) < at_.mirror_share) {
      s.wi = p.to_local(mirrors_->sample(location().mirror_cell, choice.u));
      if (s.wi.z <= 0.0f) return s;
      s.pdf = scattering_pdf(p, s.wi);
    } else {
      s = draw_scattering(p, choice);
      if (!(s.pdf > 0.0f)) return s;
    }
    const float guide = at_.mirror_share * mirrors_->pdf(location().mirror_cell, p.to_world(s.wi));
    s.pdf = (1.0f - at_.mirror_share) * s.pdf + guide;
    at_.guided = s.pdf > 0.0f ? guide / s.pdf : 0.0f;
    return s;
  }

  /// Largest weight of arriving light, for this pixel or for its tile: a path that is worth little for its own pixel
  /// must not end if the tile still uses it.
  float largest_weight() const { return std::max(largest(weight_.full), largest(weight_.shared)); }

  bool survives() {
    const float weight = largest_weight();
    if (!(weight > 0.0f) || !is_finite(weight_.full) || !is_finite(weight_.shared)) return false;
    if (bounce_ + 1 < kRouletteBounce) return true;
    const float survival = std::min(weight, kMostSurvival);
    if (sampler_.single(dimension(kRoulette)) >= survival) return false;
    scale(glm::vec3(1.0f / survival));
    return true;
  }

  /// Random numbers of all shadow rays to the sky (one sequence over all paths of the pixel) and of the scattered ray.
  void draw_numbers() {
    static_assert(kMostShadowRays < PathSampler::Pairs::kMost);
    at_.numbers.dimension.fill(dimension(kEnvironment));
    for (std::uint32_t k = 0; k < kMostShadowRays; ++k) at_.numbers.index[k] = sampler_.index * at_.shadow_rays + k;
    at_.numbers.dimension[kMostShadowRays] = dimension(kDirection);
    at_.numbers.index[kMostShadowRays] = sampler_.index;
    PathSampler::draw(sampler_.seed, &at_.numbers);
  }

  void choose_environment(const SurfacePoint& p) {
    if (environment_.black()) return;
    ShadingLocation& location = at_.locations[at_.location];
    if (location.cell != LightGuide::kNoCell && !location.has_shares)
      environment_.compute_shares(location.cell, p.n, &location.shares);
    location.has_shares = true;
    environment_.choose_directions(at_.numbers, location.cell, shares(), sampler_.index,
                                   std::span(at_.choices).first(at_.shadow_rays));
  }
  const LeafShares* shares() const { return location().cell != LightGuide::kNoCell ? &location().shares : nullptr; }

  /// Traces the shadow ray; false where it is blocked.
  bool trace_light(const SurfacePoint& p, ShadowRay* light) {
    const LightDraw& draw = light->draw;
    light->above = false;
    if (glm::dot(draw.direction, p.normal) <= 0.0f) return false;
    const glm::vec3 wi = p.to_local(draw.direction);
    if (wi.z <= 0.0f) return false;
    light->above = true;
    Ray ray{location().origin, draw.direction, 0.0f, draw.distance};
    // Stops short of a near light, because its distance and direction are rounded.
    if (draw.distance < 3e38f) ray.far *= 1.0f - 1e-4f;
    ++result_.rays;
    light->query.wi = wi;
    return find_passage(scene_, ray, &light->passage);
  }

  void add_light(const SurfacePoint& p, ShadowRay* light) {
    LightDraw& draw = light->draw;
    if (draw.texel >= 0) environment_.fill(&draw, shares());
    const Scattering s = evaluate_scattering(p, light->query);
    const float density = light->rays * draw.pdf + (draw.has_extent ? mixed_pdf(s.pdf, draw.direction) : 0.0f);
    if (!(density > 0.0f)) return;
    const glm::vec3 arriving = draw.radiance * light->through * (light->query.wi.z / density);
    const glm::vec3 shared = weight_.view_independent + weight_.shared * s.f;
    result_.radiance += (weight_.full * s.f - reconnection_.carried * shared) * arriving;
    reconnection_.light += shared * arriving;
  }

  const PathScene& scene_;
  const EnvironmentLight& environment_;
  int max_bounces_;
  const MirrorGuide* mirrors_;
  const CameraRay* camera_ray_ = nullptr;
  PathSampler sampler_;
  PathEstimate result_;
  std::size_t branches_ = 0;  ///< branches of the camera ray that were started
  std::uint32_t base_ = 0;    ///< first dimension of this branch
  Step step_ = Step::none;
  Ray ray_;
  RayHit hit_;
  SurfacePoint hit_point_;
  const SurfacePoint* point_ = nullptr;  ///< hit_point_, or a point of the camera ray
  PathWeight weight_;
  bool in_tile_ = false, reconnecting_ = false;  ///< shares with its tile; is on the branch that is shared
  Reconnection reconnection_;
  Polarisation polarisation_;  ///< polarisation by glass since the last surface
  int bounce_ = 0;             ///< scattering surfaces so far
  int vertex_ = 0;             ///< surfaces hit so far, panes included
  float pdf_ = 0.0f;           ///< density of the last scattering; 0: shadow rays cannot find what is hit
  glm::vec3 scattered_at_{0.0f};
  glm::vec3 from_{0.0f};  ///< start of the ray, on the surface itself
  PathVertex at_;         ///< the current surface
};

}  // namespace maquette
