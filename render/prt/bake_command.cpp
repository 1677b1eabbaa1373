#include "render/prt/bake_command.h"

#include <chrono>
#include <cstdio>

#include "render/bake/bake_settings.h"
#include "render/prt/job.h"
#include "render/scene_state/material_overrides.h"
#include "scenes/error.h"

namespace maquette {

std::vector<std::string> transfer_bake_settings() {
  return {"prt.faces",   "prt.clusters",     "prt.components", "prt.btf_components", "prt.btf_error",
          "prt.bounces", "prt.vertices",     "prt.form",       "prt.texel_clusters", "prt.joint_clusters",
          "prt.rays",    "prt.vertex_error", "prt.parts",      "prt.shadows"};
}

namespace {

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

TransferJob make_job(const BakeRequest& request, const Settings& settings) {
  auto scene = std::make_shared<Scene>(request.scene);
  scene->materials = effective_materials(request.scene, request.materials);
  MeasuredLibrary library;
  const TransferInput input{
      scene, std::make_shared<const FlatGeometry>(flatten(request.scene)), request.variant, {}, settings};
  TransferJob job = make_transfer_job(input, request.folder, &library);
  if (job.folder.empty()) throw Error("maquette bake", "the cache is switched off", "name a folder: -o DIR");
  job.must_work = job.may_make = true;
  return job;
}

void run(const BakeRequest& request, const BakeControl& control) {
  const std::string& folder = request.folder.empty() ? request.settings.get_string("prt.bake") : request.folder;
  const std::vector<std::string> names = transfer_bake_settings();
  const Settings settings =
      with_settings_of(transfer_folder(folder, request.scene.name, ""), request.settings, names, request.given);
  const TransferJob job = make_job(request, settings);
  BakeRanks ranks = ranks_from_environment();
  if (ranks.rank == 0)
    for (const std::string& line : job.left_out) control.report(line);
  if (ranks.rank == 0 && !folder.empty()) begin_bake_settings(job.folder, settings, names);
  ranks.say = [&](const std::string& text) {
    if (ranks.rank == 0) control.report(text);
  };
  const auto begin = std::chrono::steady_clock::now();
  const auto transfer = bake_transfer(job, ranks, nullptr, control.cancel, [&](double share) {
    if (ranks.rank == 0) control.progress("radiance transfer", share);
  });
  if (!transfer) throw Error(job.folder, "the bake was interrupted", "the same command resumes it");
  if (ranks.rank != 0) return;
  const TransferBake& bake = *transfer->bake;
  for (std::size_t p = 0; p < job.densities.size(); ++p) {
    const DrawItem& item = job.geometry->items[job.parts[p].item];
    char line[240];
    std::snprintf(line, sizeof line, "%s: triangles divided into %d, light between vertices missed by %.1f %%",
                  item.node < 0 ? "a part" : request.scene.nodes[static_cast<std::size_t>(item.node)].name.c_str(),
                  1 << (2 * job.densities[p].level), 100.0 * job.densities[p].error);
    control.report(line);
  }
  if (bake.bounce_bytes > 0) {
    char line[160];
    std::snprintf(line, sizeof line, "%d reflections: %.1f s, %.0f MB while baking", bake.options.bounces,
                  bake.bounce_seconds, 1e-6 * static_cast<double>(bake.bounce_bytes));
    control.report(line);
  }
  std::size_t matrices = 0;
  for (const TransferGroup& group : bake.groups) {
    char line[240];
    std::snprintf(line, sizeof line,
                  "%s: %zu vertices of %zu bytes, %zu views, %d components, error of the material %.2f %%",
                  group.material->name.c_str(), group.vertices.size(), bake.bytes_per_vertex(group),
                  group.material->views.size(), group.fit.components, 100.0 * group.fit.error);
    control.report(line);
    matrices += group.matrices.size();
  }
  char text[240];
  std::snprintf(text, sizeof text,
                ": %zu parts, %zu matrices, error of material and transfer %.2f %%, light side %.0f MB, %.1f s, %zu of "
                "%zu blocks "
                "reused",
                job.parts.size(), matrices, 100.0 * bake.error(), 1e-6 * static_cast<double>(bake.table.bytes()),
                seconds_since(begin), bake.reused, bake.blocks);
  control.report(job.folder + text);
}

}  // namespace

BakeCommand transfer_bake_command() {
  return {"prt", "transfer of light to the vertices of parts; under mpirun processes share the work", run};
}

}  // namespace maquette
