#include "render/prt/transfer_place.h"

#include <algorithm>
#include <cstdio>

#include "render/bake/bake_attributes.h"
#include "render/bake/kept_bakes.h"

namespace maquette {

namespace {
constexpr std::size_t kOccluderPoints = 256;
}  // namespace

std::vector<glm::vec3> occluder_points(const TransferJob& job) {
  std::vector<glm::vec3> all, points;
  for (std::size_t i = 0; i < job.geometry->items.size(); ++i) {
    const DrawItem& item = job.geometry->items[i];
    if (!job.occluding[i]) continue;
    all.insert(all.end(), job.geometry->positions.begin() + item.first_vertex,
               job.geometry->positions.begin() + item.first_vertex + item.vertex_count);
  }
  const std::size_t step = std::max<std::size_t>(1, (all.size() + kOccluderPoints - 1) / kOccluderPoints);
  for (std::size_t i = 0; i < all.size(); i += step) points.push_back(all[i]);
  return points;
}

std::vector<glm::vec3> positions_of(const TransferMesh& mesh) {
  std::vector<glm::vec3> positions;
  for (const TransferVertex& v : mesh.vertices) positions.push_back(v.position);
  return positions;
}

std::string option_difference(const TransferProvenance& found, const TransferProvenance& wanted) {
  const auto differ = [](const char* what, int a, int b) {
    return std::string(what) + " " + std::to_string(a) + " instead of " + std::to_string(b);
  };
  const bool joint = wanted.texel_clusters > 0;
  if ((found.texel_clusters > 0) != joint)
    return joint ? "prt.form=views instead of joint" : "prt.form=joint instead of views";
  if (found.faces != wanted.faces) return differ("prt.faces", found.faces, wanted.faces);
  if (found.rays != wanted.rays) return differ("prt.rays", found.rays, wanted.rays);
  if (found.clusters != wanted.clusters)
    return differ(joint ? "prt.joint_clusters" : "prt.clusters", found.clusters, wanted.clusters);
  if (found.components != wanted.components) return differ("prt.components", found.components, wanted.components);
  if (found.btf_components != wanted.btf_components)
    return differ("prt.btf_components", found.btf_components, wanted.btf_components);
  if (found.btf_error != wanted.btf_error) {
    char text[80];
    std::snprintf(text, sizeof text, "prt.btf_error %.6g instead of %.6g", 100.0 * found.btf_error,
                  100.0 * wanted.btf_error);
    return text;
  }
  if (found.bounces != wanted.bounces) return differ("prt.bounces", found.bounces, wanted.bounces);
  if (found.texel_clusters != wanted.texel_clusters)
    return differ("prt.texel_clusters", found.texel_clusters, wanted.texel_clusters);
  if (found.shape != wanted.shape) return "another mesh, or other parts, of scene " + found.scene;
  if (found.materials != wanted.materials) return "other materials of scene " + found.scene;
  // Not known before the materials were factorised.
  if (found.fit != wanted.fit && wanted.fit != 0) return "another joint factorisation of the materials";
  return {};
}

Placement place(const TransferProvenance& found, const std::vector<glm::vec3>& positions,
                const std::vector<glm::vec3>& occluders, const TransferProvenance& wanted, const TransferMesh& mesh,
                const std::vector<glm::vec3>& occluders_now) {
  Placement placement;
  if (found.geometry == wanted.geometry)
    placement.motion = RigidMotion{};
  else
    placement.motion = find_rigid_motion(positions, positions_of(mesh));
  if (!placement.motion) return placement;
  if (found.geometry == wanted.geometry && found.occluders == wanted.occluders) return placement;
  if (occluders.size() != occluders_now.size()) {
    placement.shadows_fit = false;
    placement.why = "there is more or less that casts shadows";
    return placement;
  }
  double size = 0.0, farthest = 0.0;
  std::size_t moved = 0;
  for (const glm::vec3& p : occluders_now) size = std::max(size, static_cast<double>(glm::length(p)));
  for (std::size_t i = 0; i < occluders.size(); ++i) {
    const double far = glm::length(placement.motion->rotation * glm::dvec3(occluders[i]) + placement.motion->shift -
                                   glm::dvec3(occluders_now[i]));
    farthest = std::max(farthest, far);
    moved += far > 1e-5 * size ? 1 : 0;
  }
  placement.shadows_fit = moved == 0;
  char text[160];
  std::snprintf(text, sizeof text,
                "what casts shadows did not turn along with its parts: %.0f %% of it is elsewhere, by up to %.3g m",
                100.0 * static_cast<double>(moved) / static_cast<double>(std::max<std::size_t>(occluders.size(), 1)),
                farthest);
  if (moved > 0) placement.why = text;
  return placement;
}

TransferProvenance provenance_of(const TransferJob& job, const TransferMesh& mesh) {
  TransferProvenance p;
  // A file's name without its folder: the same scene elsewhere is the same.
  p.scene = job.scene.starts_with("builtin:") ? job.scene : bake_name_of_scene(job.scene);
  std::vector<std::uint64_t> shape{mesh.vertices.size(), mesh.triangles.size()};
  for (const TransferPart& part : mesh.parts) shape.push_back(part.group);
  for (const auto& t : mesh.triangles) shape.push_back(static_cast<std::uint64_t>(t.level));
  p.shape = chain_hash(mesh.grid, chain_hash(shape, 0));
  std::vector<float> frames;
  for (const TransferVertex& v : mesh.vertices)
    for (const glm::vec3& x : {v.position, v.n, v.t, v.b}) frames.insert(frames.end(), {x.x, x.y, x.z});
  p.geometry = chain_hash(frames, p.shape);
  std::vector<std::uint32_t> corners;
  std::vector<glm::vec3> occluders;
  for (std::size_t i = 0; i < job.geometry->items.size(); ++i) {
    const DrawItem& item = job.geometry->items[i];
    if (!job.occluding[i]) continue;
    for (std::uint32_t k = 0; k < item.index_count; ++k)
      corners.push_back(job.geometry->indices[item.first_index + k] - item.first_vertex);
    occluders.insert(occluders.end(), job.geometry->positions.begin() + item.first_vertex,
                     job.geometry->positions.begin() + item.first_vertex + item.vertex_count);
  }
  p.occluders = chain_hash(occluders, chain_hash(corners, 0));
  std::vector<std::uint64_t> materials;
  for (const auto& material : job.materials) materials.push_back(material->hash);
  p.materials = chain_hash(materials, 0);
  p.faces = job.options.faces;
  p.rays = job.options.rays;
  p.clusters = job.options.clusters;
  p.components = job.options.components;
  p.btf_components = job.options.btf_components;
  p.btf_error = job.options.btf_error;
  p.bounces = job.options.bounces;
  if (job.options.joint) {
    p.texel_clusters = job.options.texel_clusters;
    p.clusters = job.options.joint_clusters;
  }
  return p;
}

}  // namespace maquette
