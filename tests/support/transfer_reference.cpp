#include "tests/support/transfer_reference.h"

#include <algorithm>

#include "render/frame/camera.h"
#include "render/prt/transfer.h"
#include "render/reference/scattering.h"
#include "scenes/parallel.h"

namespace maquette::test {

namespace {

/// A view's factors at one point of the surface, and by component the light that they reflect.
struct ViewFactors {
  const BtfView* view = nullptr;
  float share = 0.0f;
  std::vector<glm::vec3> factors;
  std::vector<glm::dvec3> light;
};

/// Where light arrives.
struct Place {
  glm::vec3 origin{0.0f}, n{0.0f}, t{0.0f}, b{0.0f};
};

/// Adds `share` of the light that arrives at a place, for each view as its components take it.
void add_light(const TransferReference& r, const Place& place, double share, std::vector<ViewFactors>* views) {
  for (Eigen::Index d = 0; d < r.cube.count(); ++d) {
    double arriving = 0.0;
    glm::dvec3 mean(0.0);
    for (int i = 0; i < r.rays * r.rays; ++i) {
      const glm::dvec3 w = r.cube.direction_within(d, {(i % r.rays + 0.5) / r.rays, (i / r.rays + 0.5) / r.rays});
      const double cosine = glm::dot(w, glm::dvec3(place.n));
      if (!(cosine > 0.0) || !is_unoccluded(r.scene, {place.origin, glm::vec3(w)})) continue;
      arriving += cosine;
      mean += cosine * w;
    }
    if (!(arriving > 0.0)) continue;
    const glm::vec3 sum(mean);
    glm::vec3 local(glm::dot(place.t, sum), glm::dot(place.b, sum), glm::dot(place.n, sum));
    local.z = std::max(local.z, 1e-6f);
    local = glm::normalize(local);
    const double weight = share * arriving / (r.rays * r.rays) * r.cube.solid_angles()[d];
    const glm::dvec3 light = weight * glm::dvec3(r.light(d, 0), r.light(d, 1), r.light(d, 2));
    for (ViewFactors& v : *views) {
      v.light[0] += light;
      const DirectionWeights lights = v.view->lights->find(local);
      const std::size_t stored = v.factors.size() - 1;
      for (std::size_t c = 0; c + 1 < v.light.size(); ++c) {
        float h = 0.0f;
        for (std::size_t l = 0; l < 3; ++l)
          h += lights.weight[static_cast<int>(l)] *
               v.view->light_weights[static_cast<std::size_t>(lights.index[l]) * stored + c];
        v.light[c + 1] += static_cast<double>(h) * light;
      }
    }
  }
}

/// The triangles of a mesh by their source.
std::vector<const TransferMesh::Triangle*> by_source(const TransferReference& r) {
  std::vector<const TransferMesh::Triangle*> triangles;
  if (!r.vertices) return triangles;
  for (const TransferMesh::Triangle& t : r.vertices->triangles) {
    if (triangles.size() <= t.source) triangles.resize(t.source + 1, nullptr);
    triangles[t.source] = &t;
  }
  return triangles;
}

/// Weights of a mesh triangle's second and third corner at a hit: the path scene rotates the corners of its triangles.
glm::vec2 weights_in_mesh(const TransferReference& r, const TransferMesh::Triangle& triangle, const RayHit& hit) {
  const glm::vec3& first = r.vertices->vertices[r.vertices->grid[triangle.first]].position;
  const auto& corners = r.scene.triangles[hit.triangle].positions;
  const float traced[3] = {1.0f - hit.barycentric.x - hit.barycentric.y, hit.barycentric.x, hit.barycentric.y};
  std::size_t nearest = 0;
  for (std::size_t k = 1; k < 3; ++k)
    if (glm::distance(corners[k], first) < glm::distance(corners[nearest], first)) nearest = k;
  return {traced[(nearest + 1) % 3], traced[(nearest + 2) % 3]};
}

glm::vec3 shade(const TransferReference& r, const SurfacePoint& p, const TransferMesh::Triangle* triangle,
                const RayHit& hit) {
  const Btf& btf = *p.material->btf;
  const auto components = static_cast<std::size_t>(std::min(r.components, btf.components));
  const DirectionWeights views = btf.view_mesh.find(p.wo);
  std::vector<ViewFactors> near;
  for (std::size_t k = 0; k < 3; ++k) {
    const float share = views.weight[static_cast<int>(k)];
    if (!(share > 0.0f)) continue;
    near.push_back({&btf.views[static_cast<std::size_t>(views.index[k])], share,
                    std::vector<glm::vec3>(static_cast<std::size_t>(1 + btf.components)),
                    std::vector<glm::dvec3>(1 + components, glm::dvec3(0.0))});
    read_btf_factors(btf, *near.back().view, p.btf, near.back().factors.data());
  }
  if (triangle) {
    const TransferCorners corners = find_transfer_corners(*r.vertices, *triangle, weights_in_mesh(r, *triangle, hit));
    for (int i = 0; i < 3; ++i) {
      const TransferVertex& v = r.vertices->vertices[r.light_of[corners.vertex[i]]];
      add_light(r, {transfer_ray_origin(v), v.n, v.t, v.b}, static_cast<double>(corners.share[i]), &near);
    }
  } else {
    add_light(r, {offset_from_surface(p.position, p.error, p.normal), p.n, p.t, p.b}, 1.0, &near);
  }
  glm::dvec3 sum(0.0);
  for (const ViewFactors& v : near)
    for (std::size_t c = 0; c < v.light.size(); ++c)
      sum += static_cast<double>(v.share) * glm::dvec3(v.factors[c]) * v.light[c];
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
  const std::vector<const TransferMesh::Triangle*> triangles = by_source(r);
  parallel_for(0, width * height, [&](int i) {
    const float x = static_cast<float>(i % width) + 0.5f, y = static_cast<float>(i / width) + 0.5f;
    const Ray ray = ray_of(x, y), right = ray_of(x + 1.0f, y), down = ray_of(x, y + 1.0f);
    RayHit hit;
    if (!find_opaque(r.scene, ray, &hit)) return;
    const RayDifferential differential{right.origin, down.origin, right.direction, down.direction};
    const SurfacePoint p = resolve_surface(r.scene, ray, hit, {&differential});
    if (!p.material->btf || !p.front) return;
    const std::uint32_t source = r.scene.triangles[hit.triangle].source;
    const glm::vec3 radiance = shade(r, p, source < triangles.size() ? triangles[source] : nullptr, hit);
    for (int c = 0; c < 3; ++c) picture.at(i % width, i / width, c) = radiance[c];
    picture.at(i % width, i / width, 3) = 1.0f;
  });
  return picture;
}

}  // namespace maquette::test
