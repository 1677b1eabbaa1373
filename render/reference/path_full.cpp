// Full transport: unidirectional path tracing with next-event estimation. Source: Kajiya 1986; multiple importance
// sampling by the balance heuristic, Veach and Guibas 1995.
#include <algorithm>
#include <array>

#include "render/reference/bending.h"
#include "render/reference/path.h"
#include "render/reference/path_sharing.h"
#include "render/reference/scattering.h"

namespace maquette {

namespace {

constexpr int kRouletteBounce = 3;      ///< paths this long end by chance
constexpr float kMostSurvival = 0.95f;  ///< so that even white furnaces end
/// Away from the camera panes mirror at least so often: what they mirror is found by chance only, and is bright when it
/// is a lamp; what they let pass was found by shadow rays already.
constexpr float kLeastMirrored = 0.25f;
/// Where a guide has seen mirrored lamps, so many scattered rays look for them, and mirror at panes so often.
constexpr float kMirrorShare = 0.15f, kGuidedMirrored = 0.9f;
constexpr int kMostPanes = 4096;          ///< that one path passes between two surfaces
constexpr std::size_t kMostBranches = 8;  ///< of one camera ray
constexpr int kMostSplits = 6;            ///< panes in a row that send a camera ray both ways
/// Shadow rays to the environment at the first surface, the second and later ones. What the second sends is shared by a
/// tile, so that most is left to gain at the first.
constexpr std::array<std::uint32_t, 3> kShadowRays{5, 3, 2};
constexpr std::uint32_t kMostShadowRays = *std::max_element(kShadowRays.begin(), kShadowRays.end());
/// Shadow rays to lamps: one a surface where they may outshine what is known to arrive of the sky, as seldom as this
/// where they are dim beside it.
constexpr float kLeastLampRays = 0.125f;
constexpr float kNotWeighed = -1.0f;
/// A mirrored surface of weight w is shaded by the share kMirroredShare w of the paths: always where a pane mirrors it
/// once (0.08 at normal incidence), by chance where panes mirror a mirror image. Chance adds the square of what the
/// surface shows, (1 / share - 1) times, and most of that is direct light, which is known well.
constexpr float kMirroredShare = 16.0f;
/// Dimensions of the sampler, so many of each surface of each branch.
constexpr std::uint32_t kDimensionsASurface = 8;
constexpr std::uint32_t kDimensionsABranch = kDimensionsASurface * 256;
enum Dimension : std::uint32_t { kEnvironment, kLightChoice, kLight, kDirection, kRoulette, kPane, kChance, kGuide };

}  // namespace

/// Follows one path from the surfaces of its camera ray, in steps: each asks for the memory that the next one reads, so
/// that other paths' steps belong in between.
class FullPath {
 public:
  FullPath(const PathScene& scene, const EnvironmentLight& environment, int max_bounces, const MirrorGuide* mirrors)
      : scene_(scene), environment_(environment), max_bounces_(max_bounces), mirrors_(mirrors) {}

  /// `shares`: light with others of its tile.
  void begin(const CameraRay& ray, const PathSampler& sampler, bool shares) {
    camera_ray_ = &ray;
    sampler_ = sampler;
    result_ = {};
    in_tile_ = shares;
    link_ = {};
    branches_ = 0;
    next_branch();
  }
  bool ended() const { return step_ == Step::none; }
  const PathEstimate& result() const { return result_; }
  /// What it shares, once it has ended.
  const PathLink& link() const { return link_; }

  /// To the next surface, or out of the scene.
  void trace() {
    if (step_ != Step::trace) return;
    ++result_.rays;
    if (intersect(scene_, ray_, RayKind::path, sampler_.word(dimension(kChance)), &hit_)) {
      const auto* triangle = reinterpret_cast<const char*>(&scene_.triangles[hit_.triangle]);
      __builtin_prefetch(triangle);
      __builtin_prefetch(triangle + 64);
      step_ = Step::meet;
    } else {
      add_environment();
      next_branch();
    }
  }

  void meet() {
    if (step_ != Step::meet) return;
    resolve_surface(scene_, ray_, hit_, {}, &met_);
    at_ = &met_;
    ++vertex_;
    if ((met_.material->bends() && pass_bending(met_)) || (met_.material->clear() > 0.0f && pass_pane(met_))) {
      go_on(vertex_ < kMostPanes && largest_weight() > 0.0f);
      return;
    }
    add_emission(met_);
    step_ = Step::scatter;
    if (linking_ && bounce_ == 1 && vertex_ == 1) reach(met_);
    if (met_.material->values.unlit) next_branch();
  }

  /// At a surface that scatters: where it is.
  void look() {
    if (step_ != Step::scatter) return;
    const SurfacePoint& p = *at_;
    shadow_rays_ = kShadowRays[static_cast<std::size_t>(std::min(bounce_, 2))];
    polarisation_ = {};
    find_place(p);
    draw_numbers();
    scattering_ = choose_scattering(p, numbers_[kMostShadowRays]);
  }

  /// Directions to light and on.
  void choose() {
    if (step_ != Step::scatter) return;
    const SurfacePoint& p = *at_;
    ask_mirrors(p);
    weigh_lamps();
    if (has_lamp_) {
      const std::uint32_t choice = dimension(kLightChoice);
      picked_ = choose_light(scene_.lights, place().lamp_cell, sampler_.single(choice), sampler_.word(choice));
      prefetch_scene_light(scene_, picked_);
    }
    choose_environment(p);
    drawn_ = bounce_ < max_bounces_ ? draw_direction(p, scattering_) : DrawnDirection();
    query_.wi = drawn_.wi;
  }

  /// Shadow rays.
  void ask_lights() {
    if (step_ != Step::scatter) return;
    arrived_ = 0;
    std::array<float, kMostShadowRays> useful;
    useful.fill(-1.0f);  // not sent
    for (std::uint32_t k = 0; k < shadow_rays_ && !environment_.black(); ++k) {
      ArrivingLight& light = arriving_[arrived_];
      environment_.take(choices_[k], &light.draw);
      light.rays = static_cast<float>(shadow_rays_);
      light.choice = k;
      arrived_ += trace_light(*at_, &light) ? 1 : 0;
      if (light.above) useful[k] = 0.0f;
    }
    const std::size_t of_sky = arrived_;
    LightDraw lamp;
    if (has_lamp_) lamp = draw_scene_light(scene_, at_->position, picked_, sampler_.pair(dimension(kLight)), false);
    if (lamp.pdf > 0.0f) {
      arriving_[arrived_].draw = lamp;
      arriving_[arrived_].rays = place().lamp_rays;
      arrived_ += trace_light(*at_, &arriving_[arrived_]) ? 1 : 0;
    }
    // Panes and lessons of all rays beside each other: what one reads comes while another is reckoned.
    std::size_t kept = 0;
    for (std::size_t i = 0; i < arrived_; ++i) {
      ArrivingLight& light = arriving_[i];
      light.through = transmittance(scene_, light.draw.direction, light.passage);
      if (light.through == glm::vec3(0.0f)) continue;
      if (i < of_sky) useful[light.choice] = largest(light.through);
      if (kept != i) arriving_[kept] = light;
      ++kept;
    }
    arrived_ = kept;
    for (std::uint32_t k = 0; k < shadow_rays_; ++k)
      if (useful[k] >= 0.0f) environment_.record(choices_[k].leaf, place().cell, useful[k]);
  }

  /// Entries and cells of tables, beside those of other paths.
  void ask_tables(QueryBatch* batch) {
    if (step_ != Step::scatter) return;
    for (std::size_t i = 0; i < arrived_; ++i) batch->add(*at_, &arriving_[i].query);
    if (drawn_.pdf > 0.0f) batch->add(*at_, &query_);
  }

  /// Light that arrives straight, then on in a new direction.
  void scatter() {
    if (step_ != Step::scatter) return;
    if (linking_) link(*at_);
    for (std::size_t i = 0; i < arrived_; ++i) add_light(*at_, &arriving_[i]);
    go_on(leaves(*at_));
  }

 private:
  enum class Step { none, trace, meet, scatter };

  void go_on(bool further) {
    if (further)
      step_ = Step::trace;
    else
      next_branch();
  }

  /// To the camera ray's next surface that this path shades: what arrives there and leaves along its wo counts.
  void next_branch() {
    while (branches_ < camera_ray_->surfaces_.size()) {
      const auto branch = static_cast<std::uint32_t>(branches_);
      const CameraRay::Surface& s = camera_ray_->surfaces_[branches_++];
      const float share = s.straight ? 1.0f : std::min(1.0f, kMirroredShare * largest(s.weight));
      if (share < 1.0f && sampler_.single(kDimensionsABranch * (64 + branch)) >= share) continue;
      base_ = 1 + kDimensionsABranch * branch;
      weight_ = s.weight / share;
      shared_weight_ = steady_ = glm::vec3(0.0f);
      linking_ = in_tile_ && branch == 0 && s.straight;
      polarisation_ = {};
      bounce_ = vertex_ = 0;
      ray_ = {};
      ray_.direction = -s.point.to_world(s.point.wo);
      from_ = s.point.position;
      at_ = &s.point;
      step_ = Step::scatter;
      if (!s.point.material->bends() || !pass_bending(s.point)) return;
      step_ = Step::trace;
      if (largest(weight_) > 0.0f) return;
    }
    step_ = Step::none;
  }

  std::uint32_t dimension(Dimension which) const {
    return base_ + static_cast<std::uint32_t>(std::min(vertex_, 255)) * kDimensionsASurface + which;
  }

  void add_environment() {
    if (environment_.black()) return;
    const glm::vec4 light = environment_.radiance_and_density(ray_.direction, shares());
    add(glm::vec3(light) * share_of(light.w * static_cast<float>(shadow_rays_)));
  }

  /// What arrives: most of it is the link's, once there is one.
  void add(const glm::vec3& light) {
    result_.radiance += (weight_ - link_.carried * shared_weight_) * light;
    link_.light += shared_weight_ * light;
  }
  void scale(const glm::vec3& factor) {
    weight_ *= factor;
    shared_weight_ *= factor;
  }

  /// At the second surface.
  void reach(const SurfacePoint& p) {
    if (!link_.from || !shares_second(p, ray_.direction)) return;
    link_.reached = true;
    link_.carried = weight_;
    link_.to = p.position;
    link_.normal = p.normal;
    link_.shading_normal = p.n;
  }

  /// What the link needs of the surface that the path is about to leave.
  void link(const SurfacePoint& p) {
    steady_ = glm::vec3(0.0f);
    if (bounce_ == 0 && vertex_ == 0 && max_bounces_ > 0 && shares_first(p)) {
      link_.from = &p;
      link_.origin = place().origin;
      link_.weight = weight_;
      link_.mirror_cell = place().mirror_cell;
      link_.mirror_share = mirror_share_;
      link_.direction = p.to_world(drawn_.wi);
      link_.pdf = drawn_.pdf;
    } else if (bounce_ == 1 && link_.reached) {
      link_.end = place().origin;
      steady_ = steady_brdf(p);
    }
  }

  /// Balance heuristic against a density with which shadow rays find the same; none does behind a mirror.
  float share_of(float other) const { return pdf_ > 0.0f ? pdf_ / (pdf_ + other) : 1.0f; }

  void add_emission(const SurfacePoint& p) {
    if (p.material->values.unlit) add(p.base_color);
    if (p.emission == glm::vec3(0.0f)) return;
    const float other = pdf_ > 0.0f ? scene_light_pdf(scene_, p.triangle, scattered_at_) : 0.0f;
    add(p.emission * share_of(place().lamp_rays * other));
  }

  /// Mirrors or lets pass; false where this path treats the pane as a surface (its share that is none).
  bool pass_pane(const SurfacePoint& p) {
    const float pane = p.material->pane;
    float u = sampler_.single(dimension(kPane));
    if (u >= pane) return false;
    u /= pane;
    add_emission(p);
    const PaneRays rays = rays_of_pane(p, ray_);
    const float reflect = largest(rays.shares.reflected), pass = largest(rays.shares.transmitted);
    float probability = reflect + pass > 0.0f ? reflect / (reflect + pass) : 0.0f;
    if (reflect > 0.0f) probability = std::max(probability, glm::mix(kLeastMirrored, kGuidedMirrored, guided_));
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

  /// Solid or rough glass: mirrors or lets pass at a facet. No shadow ray finds what is behind; a weight of 0 ends the
  /// path. False as pass_pane.
  bool pass_bending(const SurfacePoint& p) {
    const TracedMaterial& m = *p.material;
    float u = sampler_.single(dimension(kPane));
    if (u >= m.pane) return false;
    u /= m.pane;
    if (m.solid && !p.front) scale(glm::exp(-m.absorption * glm::length(p.position - from_)));
    if (vertex_ > 0) add_emission(p);
    const float roughness = m.rough && !m.measured ? p.analytic.alpha : 0.0f;
    const BentRay bent = bend_at_glass(p, glm::normalize(ray_.direction), roughness,
                                       sampler_.pair(dimension(kDirection)), u, &polarisation_);
    scale(bent.weight);
    ray_ = {offset_from_surface(p.position, p.error, bent.passed ? -p.normal : p.normal), bent.direction};
    from_ = p.position;
    pdf_ = 0.0f;
    return true;
  }

  /// Whether the path goes on from a surface.
  bool leaves(const SurfacePoint& p) {
    if (!(drawn_.pdf > 0.0f)) return false;
    const glm::vec3 direction = p.to_world(drawn_.wi);
    if (glm::dot(direction, p.normal) <= 0.0f) return false;  // above the bent normal's horizon only
    const glm::vec3 f = evaluate_brdf(p, query_);
    const float scale = drawn_.wi.z / drawn_.pdf;
    weight_ *= f * scale;
    shared_weight_ = (steady_ + shared_weight_ * f) * scale;
    steady_ = glm::vec3(0.0f);
    if (!survives()) return false;
    ray_ = {place().origin, direction};
    pdf_ = drawn_.pdf;
    scattered_at_ = from_ = p.position;
    ++bounce_;
    return true;
  }

  /// Where a surface is: the same for all paths that shade it while the guides learn nothing.
  struct Place {
    glm::vec3 position{0.0f}, error{0.0f}, normal{0.0f}, n{0.0f};  ///< of the surface that it is of
    glm::vec3 origin{0.0f};                                        ///< of rays that leave there
    std::uint32_t cell = LightGuide::kNoCell;                      ///< of the guide
    std::uint32_t mirror_cell = 0;
    std::size_t lamp_cell = 0;  ///< of the grid of lights
    float lamp_rays = 0.0f;     ///< mean number of shadow rays to lamps, or kNotWeighed
    bool looked = false;
    LeafShares shares;  ///< of the guide, once looked
  };

  /// Paths of one pixel come one after the other: most begin where the one before did.
  void find_place(const SurfacePoint& p) {
    const bool first = branches_ == 1 && bounce_ == 0 && vertex_ == 0;
    place_ = first ? 0 : 1;
    Place& place = places_[place_];
    if (first && p.position == place.position && p.error == place.error && p.normal == place.normal && p.n == place.n)
      return;
    place.position = p.position;
    place.error = p.error;
    place.normal = p.normal;
    place.n = p.n;
    place.looked = false;
    place.origin = offset_from_surface(p.position, p.error, p.normal);
    find_cells(p, &place);
    place.lamp_rays = 0.0f;
    if (scene_.lights.lights.empty()) return;
    place.lamp_rays = kNotWeighed;
    place.lamp_cell = light_cell(scene_.lights, p.position);
    prefetch_cell(scene_.lights, place.lamp_cell);
  }

  /// How many shadow rays lamps get there in the mean, and whether this path sends one.
  void weigh_lamps() {
    Place& place = places_[place_];
    if (place.lamp_rays == kNotWeighed) {
      const float lux = scene_.lights.lux[place.lamp_cell], sky = environment_.known_lux(place.cell);
      place.lamp_rays = lux < sky ? std::max(lux / sky, kLeastLampRays) : 1.0f;
    }
    has_lamp_ =
        place.lamp_rays >= 1.0f || (place.lamp_rays > 0.0f && sampler_.single(dimension(kChance)) < place.lamp_rays);
  }

  const Place& place() const { return places_[place_]; }

  /// Both guides have the same grid of places.
  void find_cells(const SurfacePoint& p, Place* place) const {
    place->cell = environment_.cell_of(p.position, p.n);
    environment_.prefetch(place->cell);
    if (!mirrors_) return;
    place->mirror_cell = place->cell != LightGuide::kNoCell ? place->cell : mirrors_->cell_of(p.position, p.n);
    mirrors_->prefetch(place->mirror_cell);
  }

  /// How many scattered rays look for mirrored lamps: of what scatters widely, where some were seen.
  void ask_mirrors(const SurfacePoint& p) {
    mirror_share_ = 0.0f;
    if (!mirrors_ || !mirrors_->knows(place().mirror_cell)) return;
    mirrors_->prefetch_entries(place().mirror_cell);
    mirror_share_ = kMirrorShare * (p.material->measured ? 1.0f : p.lobe_weights.x);
  }

  /// Density of what draw_direction draws, given the BRDF's own.
  float mixed_pdf(float own, const glm::vec3& direction) const {
    return mirrors_ ? mirrors_->mixed_pdf(own, place().mirror_cell, mirror_share_, direction) : own;
  }

  DrawnDirection draw_direction(const SurfacePoint& p, const ScatteringChoice& choice) {
    guided_ = 0.0f;
    if (!(mirror_share_ > 0.0f)) return draw_scattering(p, choice);
    DrawnDirection s;
    if (sampler_.single(dimension(kGuide)) < mirror_share_) {
      s.wi = p.to_local(mirrors_->sample(place().mirror_cell, choice.u));
      if (s.wi.z <= 0.0f) return s;
      s.pdf = scattering_pdf(p, s.wi);
    } else {
      s = draw_scattering(p, choice);
      if (!(s.pdf > 0.0f)) return s;
    }
    const float guide = mirror_share_ * mirrors_->pdf(place().mirror_cell, p.to_world(s.wi));
    s.pdf = (1.0f - mirror_share_) * s.pdf + guide;
    guided_ = s.pdf > 0.0f ? guide / s.pdf : 0.0f;
    return s;
  }

  /// Of what arrives, to this pixel or to its tile: what others count on must not end by what this one takes of it.
  float largest_weight() const { return std::max(largest(weight_), largest(shared_weight_)); }

  bool survives() {
    const float weight = largest_weight();
    if (!(weight > 0.0f) || !is_finite(weight_) || !is_finite(shared_weight_)) return false;
    if (bounce_ + 1 < kRouletteBounce) return true;
    const float survival = std::min(weight, kMostSurvival);
    if (sampler_.single(dimension(kRoulette)) >= survival) return false;
    scale(glm::vec3(1.0f / survival));
    return true;
  }

  /// Of all shadow rays to the sky, one sequence for those of all paths; then of the scattered ray.
  void draw_numbers() {
    static_assert(kMostShadowRays < PathSampler::Pairs::kMost);
    numbers_.dimension.fill(dimension(kEnvironment));
    for (std::uint32_t k = 0; k < kMostShadowRays; ++k) numbers_.index[k] = sampler_.index * shadow_rays_ + k;
    numbers_.dimension[kMostShadowRays] = dimension(kDirection);
    numbers_.index[kMostShadowRays] = sampler_.index;
    PathSampler::draw(sampler_.seed, &numbers_);
  }

  void choose_environment(const SurfacePoint& p) {
    if (environment_.black()) return;
    Place& place = places_[place_];
    if (place.cell != LightGuide::kNoCell && !place.looked) environment_.look(place.cell, p.n, &place.shares);
    place.looked = true;
    environment_.choose(numbers_, place.cell, shares(), sampler_.index, std::span(choices_).first(shadow_rays_));
  }
  const LeafShares* shares() const { return place().cell != LightGuide::kNoCell ? &place().shares : nullptr; }

  /// One of `rays` shadow rays of the same kind.
  struct ArrivingLight {
    LightDraw draw;
    float rays;
    std::uint32_t choice;  ///< of the sky's
    ScatteringQuery query;
    Passage passage;
    glm::vec3 through;
    bool above;  ///< the horizon
  };

  /// Whether any of it may come through.
  bool trace_light(const SurfacePoint& p, ArrivingLight* light) {
    const LightDraw& draw = light->draw;
    light->above = false;
    if (glm::dot(draw.direction, p.normal) <= 0.0f) return false;
    const glm::vec3 wi = p.to_local(draw.direction);
    if (wi.z <= 0.0f) return false;
    light->above = true;
    Ray ray{place().origin, draw.direction, 0.0f, draw.distance};
    // Short of a near light by the rounding of its distance and of the direction.
    if (draw.distance < 3e38f) ray.far *= 1.0f - 1e-4f;
    ++result_.rays;
    light->query.wi = wi;
    return find_passage(scene_, ray, &light->passage);
  }

  void add_light(const SurfacePoint& p, ArrivingLight* light) {
    LightDraw& draw = light->draw;
    if (draw.texel >= 0) environment_.fill(&draw, shares());
    const Scattering s = evaluate_scattering(p, light->query);
    const float density = light->rays * draw.pdf + (draw.has_extent ? mixed_pdf(s.pdf, draw.direction) : 0.0f);
    if (!(density > 0.0f)) return;
    const glm::vec3 arriving = draw.radiance * light->through * (light->query.wi.z / density);
    const glm::vec3 shared = steady_ + shared_weight_ * s.f;
    result_.radiance += (weight_ * s.f - link_.carried * shared) * arriving;
    link_.light += shared * arriving;
  }

  const PathScene& scene_;
  const EnvironmentLight& environment_;
  int max_bounces_;
  const MirrorGuide* mirrors_;
  const CameraRay* camera_ray_ = nullptr;
  PathSampler sampler_;
  PathEstimate result_;
  std::size_t branches_ = 0;  ///< of the camera ray that were begun
  std::uint32_t base_ = 0;    ///< of the dimensions
  Step step_ = Step::none;
  Ray ray_;
  RayHit hit_;
  SurfacePoint met_;
  const SurfacePoint* at_ = nullptr;  ///< met_, or the camera ray's
  glm::vec3 weight_{1.0f};
  bool in_tile_ = false, linking_ = false;  ///< with its tile; on the branch that does
  PathLink link_;
  glm::vec3 shared_weight_{0.0f};  ///< of what arrives, in the link's light: part of weight_, less what is carried
  glm::vec3 steady_{0.0f};         ///< 1/sr, where it is the second surface
  Polarisation polarisation_;      ///< by glass since the last surface
  int bounce_ = 0;                 ///< surfaces that scattered so far
  int vertex_ = 0;                 ///< surfaces met so far, panes included
  float pdf_ = 0.0f;               ///< density of the last scattering; 0: nothing else could have found what is hit
  glm::vec3 scattered_at_{0.0f};
  glm::vec3 from_{0.0f};  ///< of the ray, on the surface itself
  // Of the surface where it is:
  std::array<Place, 2> places_;  ///< of the camera ray's first surface; of any other
  std::size_t place_ = 1;        ///< which of them
  std::uint32_t shadow_rays_ = 0;
  PathSampler::Pairs numbers_;
  std::array<EnvironmentLight::Choice, kMostShadowRays> choices_;
  bool has_lamp_ = false;
  LightPick picked_;  ///< lamp
  std::array<ArrivingLight, kMostShadowRays + 1> arriving_;
  std::size_t arrived_ = 0;
  float mirror_share_ = 0.0f;  ///< of scattered rays that the guide draws
  float guided_ = 0.0f;        ///< probability that it drew the present ray, given its direction
  ScatteringChoice scattering_;
  DrawnDirection drawn_;
  BrdfQuery query_;
};

PathGroup::PathGroup(const PathScene& scene, const EnvironmentLight& environment, int max_bounces,
                     const MirrorGuide* mirrors)
    : scene_(scene), mirrors_(mirrors) {
  paths_.reserve(kMost);
  for (std::size_t i = 0; i < kMost; ++i) paths_.emplace_back(scene, environment, max_bounces, mirrors);
}
PathGroup::~PathGroup() = default;

void PathGroup::follow(std::span<PathTask> tasks) {
  std::array<FullPath*, kMost> under_way;
  std::size_t count = tasks.size();
  for (std::size_t i = 0; i < count; ++i) {
    under_way[i] = &paths_[i];
    const auto beside = [&](std::size_t k) { return k < tasks.size() && tasks[k].tile == tasks[i].tile; };
    paths_[i].begin(*tasks[i].ray, tasks[i].sampler, tasks[i].tile > 0 && (beside(i - 1) || beside(i + 1)));
  }
  const auto all = [&](const auto& step) {
    for (std::size_t i = 0; i < count; ++i) step(*under_way[i]);
  };
  QueryBatch batch;
  while (count > 0) {
    all([](FullPath& path) { path.trace(); });
    all([](FullPath& path) { path.meet(); });
    all([](FullPath& path) { path.look(); });
    all([](FullPath& path) { path.choose(); });
    all([](FullPath& path) { path.ask_lights(); });
    all([&](FullPath& path) { path.ask_tables(&batch); });
    batch.complete();
    all([](FullPath& path) { path.scatter(); });
    const auto end = std::remove_if(under_way.begin(), under_way.begin() + static_cast<std::ptrdiff_t>(count),
                                    [](const FullPath* path) { return path->ended(); });
    count = static_cast<std::size_t>(end - under_way.begin());
  }
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    PathEstimate& estimate = tasks[i].estimate;
    estimate = paths_[i].result();
    estimate.radiance += tasks[i].ray->radiance_;
    estimate.covered = tasks[i].ray->covered_;
  }
  share(tasks);
}

void PathGroup::share(std::span<PathTask> tasks) const {
  static_assert(kMost <= kMostLinks);
  std::array<PathLink, kMost> links;
  for (std::size_t begin = 0, end = 0; begin < tasks.size(); begin = end) {
    for (end = begin; end < tasks.size() && tasks[end].tile == tasks[begin].tile; ++end)
      links[end - begin] = paths_[end].link();
    const std::size_t count = end - begin;
    if (tasks[begin].tile == 0 || count < 2) continue;
    std::array<SharedLight, kMost> results;
    share_links(scene_, mirrors_, std::span(links).first(count), std::span(results).first(count));
    for (std::size_t i = 0; i < count; ++i) {
      tasks[begin + i].estimate.radiance += results[i].radiance;
      tasks[begin + i].estimate.rays += results[i].rays;
    }
  }
}

/// Panes send the ray both ways, blended surfaces let it go on behind them.
class CameraRay::Splitter {
 public:
  Splitter(const PathScene& scene, const EnvironmentLight& environment, const RayDifferential* differential,
           std::uint32_t chance, CameraRay* out)
      : scene_(scene), environment_(environment), differential_(differential), chance_(chance), out_(*out) {}

  void follow(const Ray& ray) {
    branches_.push_back({ray, glm::vec3(1.0f), 0, true});
    while (!branches_.empty()) {
      const Branch branch = branches_.back();
      branches_.pop_back();
      advance(branch);
    }
  }

 private:
  struct Branch {
    Ray ray;
    glm::vec3 weight;
    int splits;
    bool straight;  ///< the picture's own line of sight
  };

  void push(const Ray& ray, const glm::vec3& weight, const Branch& from, bool straight) {
    if (largest(weight) > 0.0f && from.splits < kMostPanes)
      branches_.push_back({ray, weight, from.splits + 1, straight});
  }

  void advance(const Branch& branch) {
    RayHit hit;
    ++out_.rays_;
    if (!intersect(scene_, branch.ray, differential_ ? RayKind::camera : RayKind::path, chance_, &hit)) {
      if (!environment_.black())
        out_.radiance_ +=
            branch.weight * glm::vec3(environment_.radiance_and_density(glm::normalize(branch.ray.direction)));
      return;
    }
    const SurfacePoint p = resolve_surface(scene_, branch.ray, hit, {branch.straight ? differential_ : nullptr, false});
    float surface = 1.0f - p.material->clear();
    if (p.material->clear() > 0.0f) {
      out_.radiance_ += branch.weight * p.emission * p.material->pane;
      const PaneRays rays = rays_of_pane(p, branch.ray);
      const glm::vec3 weight = branch.weight * p.material->pane;
      // The straight part last: it is followed first, and keeps its numbers whatever is mirrored.
      if (branch.splits < kMostSplits) push(rays.mirrored, weight * rays.shares.reflected, branch, false);
      push(rays.passed, weight * rays.shares.transmitted, branch, branch.straight);
    } else if (p.material->blended && differential_) {
      surface = alpha_at(scene_, hit.triangle, hit.barycentric);
      push({offset_from_surface(p.position, p.error, -p.normal), branch.ray.direction},
           branch.weight * (1.0f - surface), branch, branch.straight);
    } else {
      out_.covered_ |= branch.straight;
    }
    if (surface > 0.0f) add_surface(p, branch.weight * surface, branch.straight);
  }

  void add_surface(const SurfacePoint& p, const glm::vec3& weight, bool straight) {
    out_.radiance_ += weight * p.emission;
    if (p.material->values.unlit)
      out_.radiance_ += weight * p.base_color;
    else if (out_.surfaces_.size() < kMostBranches)
      out_.surfaces_.push_back({p, weight, straight});
  }

  const PathScene& scene_;
  const EnvironmentLight& environment_;
  const RayDifferential* differential_;
  std::uint32_t chance_;
  CameraRay& out_;
  std::vector<Branch> branches_;
};

CameraRay::CameraRay(const PathScene& scene, const EnvironmentLight& environment, const Ray& ray,
                     const RayDifferential* differential, std::uint32_t chance)
    : scene_(scene), environment_(environment) {
  Splitter(scene, environment, differential, chance, this).follow(ray);
}

glm::vec3 estimate_radiance(const PathScene& scene, const PathOptions& options, const glm::vec3& origin,
                            const glm::vec3& direction, std::uint32_t seed, std::uint32_t index) {
  const EnvironmentLight environment(scene.environment, options);
  const PathSampler sampler{seed, index};
  const Ray ray{origin, direction, 0.0f, 3.4e38f};
  if (options.transport == Transport::direct)
    return estimate_direct(scene, environment, sampler, ray, nullptr).radiance;
  const CameraRay first(scene, environment, ray, nullptr, sampler.word(0));
  PathTask task{&first, sampler, 0, {}};
  PathGroup(scene, environment, options.max_bounces).follow({&task, 1});
  return task.estimate.radiance;
}

}  // namespace maquette
