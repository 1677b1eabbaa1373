#include "tests/support/transfer_reference.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "render/frame/camera.h"
#include "render/reference/scattering.h"

namespace maquette::test {

namespace {

/// A view's factors at one point of the surface.
struct ViewFactors {
  const BtfView* view = nullptr;
  float share = 0.0f;
  std::vector<glm::vec3> factors;
};

glm::vec3 shade(const TransferReference& r, const SurfacePoint& p) {
  const Btf& btf = *p.material->btf;
  const DirectionWeights views = btf.view_mesh.find(p.wo);
  std::vector<ViewFactors> near;
  for (std::size_t k = 0; k < 3; ++k) {
    const float share = views.weight[static_cast<int>(k)];
    if (!(share > 0.0f)) continue;
    near.push_back({&btf.views[static_cast<std::size_t>(views.index[k])], share,
                    std::vector<glm::vec3>(static_cast<std::size_t>(1 + btf.components))});
    read_btf_factors(btf, *near.back().view, p.btf, near.back().factors.data());
  }
  const glm::vec3 origin = offset_from_surface(p.position, p.error, p.normal);
  const auto components = static_cast<std::size_t>(std::min(r.components, btf.components));
  glm::dvec3 sum(0.0);
  for (Eigen::Index d = 0; d < r.cube.count(); ++d) {
    double arriving = 0.0;
    glm::dvec3 mean(0.0);
    for (int i = 0; i < r.rays * r.rays; ++i) {
      const glm::dvec3 w = r.cube.direction_within(d, {(i % r.rays + 0.5) / r.rays, (i / r.rays + 0.5) / r.rays});
      const double cosine = glm::dot(w, glm::dvec3(p.n));
      if (!(cosine > 0.0) || !is_unoccluded(r.scene, {origin, glm::vec3(w)})) continue;
      arriving += cosine;
      mean += cosine * w;
    }
    if (!(arriving > 0.0)) continue;
    glm::vec3 local = p.to_local(glm::vec3(mean));
    local.z = std::max(local.z, 1e-6f);
    local = glm::normalize(local);
    glm::vec3 rho(0.0f);
    for (const ViewFactors& v : near) {
      const DirectionWeights lights = v.view->lights->find(local);
      glm::vec3 own = v.factors[0];
      for (std::size_t c = 0; c < components; ++c) {
        float h = 0.0f;
        for (std::size_t l = 0; l < 3; ++l)
          h += lights.weight[static_cast<int>(l)] * v.view->light_weights[static_cast<std::size_t>(lights.index[l]) *
                                                                              static_cast<std::size_t>(btf.components) +
                                                                          c];
        own += h * v.factors[c + 1];
      }
      rho += v.share * own;
    }
    const double weight = arriving / (r.rays * r.rays) * r.cube.solid_angles()[d];
    sum += weight * glm::dvec3(rho) * glm::dvec3(r.light(d, 0), r.light(d, 1), r.light(d, 2));
  }
  return glm::max(glm::vec3(sum), glm::vec3(0.0f));
}

}  // namespace

Image trace_transfer_reference(const TransferReference& r, const CameraView& camera, int width, int height) {
  Image picture(width, height, 4);
  const CameraFrame frame = make_camera_frame(camera, width, height, r.scene.bounds);
  const auto ray_of = [&](float x, float y) {
    const EyeRay e =
        frame.ray_through({2.0f * x / static_cast<float>(width) - 1.0f, 1.0f - 2.0f * y / static_cast<float>(height)});
    return Ray{e.origin, e.direction};
  };
  tbb::parallel_for(0, width * height, [&](int i) {
    const float x = static_cast<float>(i % width) + 0.5f, y = static_cast<float>(i / width) + 0.5f;
    const Ray ray = ray_of(x, y), right = ray_of(x + 1.0f, y), down = ray_of(x, y + 1.0f);
    RayHit hit;
    if (!find_opaque(r.scene, ray, &hit)) return;
    const RayDifferential differential{right.origin, down.origin, right.direction, down.direction};
    const SurfacePoint p = resolve_surface(r.scene, ray, hit, {&differential});
    if (!p.material->btf || !p.front) return;
    const glm::vec3 radiance = shade(r, p);
    for (int c = 0; c < 3; ++c) picture.at(i % width, i / width, c) = radiance[c];
    picture.at(i % width, i / width, 3) = 1.0f;
  });
  return picture;
}

}  // namespace maquette::test
