// Full transport: unidirectional path tracing with next-event estimation. Source: Kajiya 1986; multiple importance
// sampling by the balance heuristic, Veach and Guibas 1995.
#include <algorithm>
#include <array>

#include "render/reference/path.h"
#include "render/reference/scattering.h"

namespace maquette {

namespace {

constexpr int kRouletteBounce = 3;        ///< paths this long end by chance
constexpr float kMostSurvival = 0.95f;    ///< so that even white furnaces end
constexpr std::size_t kMostBranches = 8;  ///< of one camera path
constexpr int kMostSplits = 6;            ///< panes in a row that send a camera path both ways
/// Dimensions of the sampler: 8 of each bounce of each branch.
constexpr std::uint32_t kDimensionsABounce = 8;
constexpr std::uint32_t kDimensionsABranch = kDimensionsABounce * 256;
enum Dimension : std::uint32_t { kEnvironment, kLightChoice, kLight, kLobe, kDirection, kRoulette, kPane, kChance };

/// A part of the path that is still to be followed.
struct Branch {
  Ray ray;
  glm::vec3 weight{1.0f};
  int bounce = 0;  ///< surfaces that scattered so far
  int vertex = 0;  ///< surfaces met so far, panes included
  int splits = 0;
  bool from_camera = true;  ///< only panes so far
  bool straight = true;     ///< and none of them mirrored: the picture's own line of sight
  float pdf = 0.0f;         ///< density of the last scattering; 0: nothing else could have found what is hit
  glm::vec3 scattered_at{0.0f};
};

float largest(const glm::vec3& v) { return std::max({v.x, v.y, v.z}); }

class FullPath {
 public:
  FullPath(const PathScene& scene, const EnvironmentLight& environment, const PathSampler& sampler, int max_bounces)
      : scene_(scene), environment_(environment), sampler_(sampler), max_bounces_(max_bounces) {}

  PathEstimate follow(const Ray& ray, const RayDifferential* differential) {
    differential_ = differential;
    Branch first;
    first.ray = ray;
    push(first);
    while (count_ > 0) {
      Branch branch = branches_[--count_];
      base_ = kDimensionsABranch * branch_number_++;
      while (advance(&branch)) {
      }
    }
    return result_;
  }

 private:
  void push(const Branch& branch) {
    if (count_ < branches_.size()) branches_[count_++] = branch;
  }
  std::uint32_t dimension(const Branch& branch, Dimension which) const {
    return 1 + base_ + static_cast<std::uint32_t>(std::min(branch.vertex, 255)) * kDimensionsABounce + which;
  }

  /// To the next surface and its contribution; false when the branch has ended.
  bool advance(Branch* branch) {
    RayHit hit;
    ++result_.rays;
    const bool camera = branch->from_camera && differential_;
    const std::uint32_t chance = sampler_.word(dimension(*branch, kChance));
    if (!intersect(scene_, branch->ray, camera ? RayKind::camera : RayKind::path, chance, &hit)) {
      add_environment(*branch);
      return false;
    }
    const SurfaceOptions options{branch->straight ? differential_ : nullptr, false};
    const SurfacePoint p = resolve_surface(scene_, branch->ray, hit, options);
    if (p.material->pane > 0.0f && pass_pane(branch, p)) return ++branch->vertex < 4096;
    if (camera && p.material->blended) split_blended(branch, p, alpha_at(scene_, hit.triangle, hit.barycentric));
    if (branch->straight && !p.material->blended && p.material->pane <= 0.0f) result_.covered = true;
    add_emission(*branch, p);
    if (p.material->values.unlit) return false;
    return scatter(branch, p);
  }

  void add_environment(const Branch& branch) {
    if (environment_.black()) return;
    const glm::vec4 light = environment_.radiance_and_density(glm::normalize(branch.ray.direction));
    const float weight = branch.pdf > 0.0f ? branch.pdf / (branch.pdf + light.w) : 1.0f;
    result_.radiance += branch.weight * glm::vec3(light) * weight;
  }

  void add_emission(const Branch& branch, const SurfacePoint& p) {
    if (p.material->values.unlit) result_.radiance += branch.weight * p.base_color;
    if (p.emission == glm::vec3(0.0f)) return;
    float weight = 1.0f;
    if (branch.pdf > 0.0f) {
      const float other = scene_light_pdf(scene_, p.triangle, branch.scattered_at, p.position);
      weight = branch.pdf / (branch.pdf + other);
    }
    result_.radiance += branch.weight * p.emission * weight;
  }

  /// Mirrors or lets pass; false where this path treats the pane as a surface (its share that is none).
  bool pass_pane(Branch* branch, const SurfacePoint& p) {
    const TracedMaterial& m = *p.material;
    float u = sampler_.single(dimension(*branch, kPane));
    if (m.pane < 1.0f) {
      if (u >= m.pane) return false;
      u /= m.pane;
    }
    add_emission(*branch, p);
    const PaneShares shares = pane_shares(p.wo.z, m.values.ior, glm::clamp(p.base_color, 0.0f, 1.0f));
    Branch mirrored = *branch;
    mirrored.weight *= shares.reflected;
    mirrored.straight = false;
    mirrored.pdf = 0.0f;
    mirrored.ray.origin = offset_from_surface(p.position, p.error, p.normal);
    mirrored.ray.direction = p.to_world({-p.wo.x, -p.wo.y, p.wo.z});
    mirrored.ray.near = 0.0f;
    // Below the true surface by a bent normal: it would leave through the pane.
    if (glm::dot(mirrored.ray.direction, p.normal) <= 0.0f) mirrored.weight = glm::vec3(0.0f);
    branch->weight *= shares.transmitted;
    branch->ray.origin = offset_from_surface(p.position, p.error, -p.normal);
    branch->ray.near = 0.0f;
    if (branch->from_camera && branch->splits < kMostSplits) {
      ++branch->splits;
      mirrored.splits = branch->splits;
      mirrored.vertex = branch->vertex + 1;
      if (largest(mirrored.weight) > 0.0f) push(mirrored);
      return true;
    }
    const float reflect = largest(mirrored.weight), pass = largest(branch->weight);
    if (!(reflect + pass > 0.0f)) {
      branch->weight = glm::vec3(0.0f);
      return true;
    }
    const float probability = reflect / (reflect + pass);
    if (u < probability) {
      mirrored.vertex = branch->vertex;
      *branch = mirrored;
      branch->weight /= probability;
    } else {
      branch->weight /= 1.0f - probability;
    }
    return true;
  }

  /// A camera path goes on behind a blended surface as well.
  void split_blended(Branch* branch, const SurfacePoint& p, float alpha) {
    Branch behind = *branch;
    behind.weight *= 1.0f - alpha;
    behind.ray.origin = offset_from_surface(p.position, p.error, -p.normal);
    behind.ray.near = 0.0f;
    ++behind.vertex;
    if (largest(behind.weight) > 0.0f) push(behind);
    branch->weight *= alpha;
  }

  /// Light that arrives straight, then on in a new direction. False when the path ends.
  bool scatter(Branch* branch, const SurfacePoint& p) {
    add_direct(*branch, p);
    if (branch->bounce >= max_bounces_) return false;
    const ScatteringSample s =
        sample_scattering(p, sampler_.pair(dimension(*branch, kDirection)), sampler_.single(dimension(*branch, kLobe)));
    if (!(s.pdf > 0.0f)) return false;
    const glm::vec3 direction = p.to_world(s.wi);
    if (glm::dot(direction, p.normal) <= 0.0f) return false;  // into the surface, above the bent normal's horizon only
    branch->weight *= s.f * (s.wi.z / s.pdf);
    if (!survives(branch)) return false;
    branch->ray = {offset_from_surface(p.position, p.error, p.normal), direction, 0.0f, 3.4e38f};
    branch->pdf = s.pdf;
    branch->scattered_at = p.position;
    branch->from_camera = branch->straight = false;
    ++branch->bounce;
    ++branch->vertex;
    return true;
  }

  bool survives(Branch* branch) const {
    const float weight = largest(branch->weight);
    if (!(weight > 0.0f) || !std::isfinite(weight)) return false;
    if (branch->bounce + 1 < kRouletteBounce) return true;
    const float survival = std::min(weight, kMostSurvival);
    if (sampler_.single(dimension(*branch, kRoulette)) >= survival) return false;
    branch->weight /= survival;
    return true;
  }

  void add_direct(const Branch& branch, const SurfacePoint& p) {
    if (!environment_.black()) {
      const LightDraw light = environment_.draw(sampler_.pair(dimension(branch, kEnvironment)));
      add_light(branch, p, light);
    }
    if (!scene_.lights.lights.empty()) {
      const LightDraw light = draw_scene_light(scene_, p.position, sampler_.single(dimension(branch, kLightChoice)),
                                               sampler_.pair(dimension(branch, kLight)), false);
      add_light(branch, p, light);
    }
  }

  void add_light(const Branch& branch, const SurfacePoint& p, const LightDraw& light) {
    if (!(light.pdf > 0.0f) || glm::dot(light.direction, p.normal) <= 0.0f) return;
    const glm::vec3 wi = p.to_local(light.direction);
    if (wi.z <= 0.0f) return;
    const Scattering s = evaluate_scattering(p, wi);
    const glm::vec3 value =
        branch.weight * s.f * light.radiance * (wi.z / (light.pdf + (light.has_extent ? s.pdf : 0.0f)));
    if (!(largest(value) > 0.0f)) return;
    Ray ray{offset_from_surface(p.position, p.error, p.normal), light.direction, 0.0f, light.distance};
    // Short of a near light by the rounding of its distance and of the direction.
    if (light.distance < 3e38f) ray.far *= 1.0f - 1e-4f;
    ++result_.rays;
    result_.radiance += value * transmittance(scene_, ray);
  }

  const PathScene& scene_;
  const EnvironmentLight& environment_;
  PathSampler sampler_;
  int max_bounces_;
  const RayDifferential* differential_ = nullptr;
  PathEstimate result_;
  std::array<Branch, kMostBranches> branches_;
  std::size_t count_ = 0;
  std::uint32_t base_ = 0, branch_number_ = 0;
};

}  // namespace

PathEstimate estimate_full(const PathScene& scene, const EnvironmentLight& environment, const PathSampler& sampler,
                           const Ray& ray, const RayDifferential* differential, int max_bounces) {
  return FullPath(scene, environment, sampler, max_bounces).follow(ray, differential);
}

glm::vec3 estimate_radiance(const PathScene& scene, const PathOptions& options, const glm::vec3& origin,
                            const glm::vec3& direction, std::uint32_t seed, std::uint32_t index) {
  const EnvironmentLight environment(scene.environment, options);
  const PathSampler sampler{seed, index};
  const Ray ray{origin, direction, 0.0f, 3.4e38f};
  return options.transport == Transport::direct
             ? estimate_direct(scene, environment, sampler, ray, nullptr).radiance
             : estimate_full(scene, environment, sampler, ray, nullptr, options.max_bounces).radiance;
}

}  // namespace maquette
