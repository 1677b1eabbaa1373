// First surfaces of a camera ray: behind panes and in their reflections.
#include "render/reference/path.h"
#include "render/reference/path_constants.h"
#include "render/reference/scattering.h"

namespace maquette {

namespace {

constexpr std::size_t kMostBranches = 8;  ///< of one camera ray
constexpr int kMostSplits = 6;            ///< consecutive panes at which a camera ray is split

}  // namespace

/// Splits a camera ray: panes reflect and transmit it, blended surfaces let it continue behind them.
class CameraRay::Splitter {
 public:
  Splitter(const PathScene& scene, const EnvironmentLight& environment, const RayDifferential* differential,
           std::uint32_t chance, const SeenShare* share, CameraRay* out)
      : scene_(scene),
        environment_(environment),
        differential_(differential),
        chance_(chance),
        share_(share),
        out_(*out) {}

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
    glm::vec3 weight{};
    int splits;
    bool straight;  ///< not reflected: the camera's own line of sight
  };

  void push(const Ray& ray, const glm::vec3& weight, const Branch& from, bool straight) {
    if (largest(weight) > 0.0f && from.splits < kMostPanes)
      branches_.push_back({ray, weight, from.splits + 1, straight});
  }

  void advance(const Branch& branch) {
    RayHit hit;
    ++out_.rays_;
    const RayDifferential* footprint = branch.straight ? differential_ : nullptr;
    if (!intersect(scene_, branch.ray, differential_ ? RayKind::camera : RayKind::path, chance_, &hit, footprint)) {
      if (environment_.black()) return;
      const glm::vec4 sky = environment_.radiance_and_density(glm::normalize(branch.ray.direction));
      out_.radiance_ += branch.weight * glm::vec3(sky) * share_of(branch, kNoTriangle, sky.w);
      return;
    }
    const SurfacePoint p = resolve_surface(scene_, branch.ray, hit, {footprint});
    const bool splits = p.material->blended && differential_;
    float alpha = 1.0f;
    if (splits)
      alpha = footprint ? alpha_at(scene_, hit.triangle, hit.barycentric, *footprint)
                        : alpha_at(scene_, hit.triangle, hit.barycentric);
    const glm::vec3 covered = branch.weight * alpha;
    glm::vec3 behind = branch.weight * (1.0f - alpha);
    float surface = 1.0f;
    if (p.material->clear() > 0.0f) {
      surface = 1.0f - p.pane;
      out_.radiance_ += covered * p.emission * (p.pane * share_of(branch, hit.triangle, 0.0f));
      const PaneRays rays = rays_of_pane(p, branch.ray);
      const glm::vec3 weight = covered * p.pane;
      if (branch.splits < kMostSplits) push(rays.mirrored, weight * rays.shares.reflected, branch, false);
      behind += weight * rays.shares.transmitted;
    } else if (!splits) {
      out_.covered_ |= branch.straight;
    }
    // Push the straight part last, so that it is traced first: its random numbers do not depend on what is reflected.
    Ray beyond{offset_from_surface(p.position, p.error, -p.normal), branch.ray.direction};
    beyond.far = std::max(branch.ray.far - hit.distance, 0.0f);  // what an eye sees may end at a section plane
    push(beyond, behind, branch, branch.straight);
    if (surface > 0.0f) add_surface(p, covered * surface, branch);
  }

  float share_of(const Branch& branch, std::uint32_t triangle, float sky_density) const {
    return share_ && branch.straight ? (*share_)(triangle, sky_density) : 1.0f;
  }

  void add_surface(const SurfacePoint& p, const glm::vec3& weight, const Branch& branch) {
    if (p.emission != glm::vec3(0.0f)) out_.radiance_ += weight * p.emission * share_of(branch, p.triangle, 0.0f);
    if (p.material->values.unlit)
      out_.radiance_ += weight * p.base_color;
    else if (out_.surfaces_.size() < kMostBranches)
      out_.surfaces_.push_back({p, weight, branch.straight});
  }

  const PathScene& scene_;
  const EnvironmentLight& environment_;
  const RayDifferential* differential_;
  std::uint32_t chance_;
  const SeenShare* share_;
  CameraRay& out_;
  std::vector<Branch> branches_;
};

CameraRay::CameraRay(const PathScene& scene, const EnvironmentLight& environment, const Ray& ray,
                     const RayDifferential* differential, std::uint32_t chance, const SeenShare* share)
    : scene_(scene), environment_(environment) {
  Splitter(scene, environment, differential, chance, share, this).follow(ray);
}

}  // namespace maquette
