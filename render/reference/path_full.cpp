// Paths of full transport beside each other, step by step.
#include <algorithm>
#include <array>

#include "render/reference/full_path.h"

namespace maquette {

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
    all([](FullPath& path) { path.resolve_hit(); });
    all([](FullPath& path) { path.prepare_surface(); });
    all([](FullPath& path) { path.choose_directions(); });
    all([](FullPath& path) { path.trace_shadow_rays(); });
    all([&](FullPath& path) { path.add_queries(&batch); });
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
  static_assert(kMost <= kMaxReconnections);
  std::array<Reconnection, kMost> reconnections;
  for (std::size_t begin = 0, end = 0; begin < tasks.size(); begin = end) {
    for (end = begin; end < tasks.size() && tasks[end].tile == tasks[begin].tile; ++end)
      reconnections[end - begin] = paths_[end].reconnection();
    const std::size_t count = end - begin;
    if (tasks[begin].tile == 0 || count < 2) continue;
    std::array<SharedLight, kMost> results;
    share_light(scene_, mirrors_, std::span(reconnections).first(count), std::span(results).first(count));
    for (std::size_t i = 0; i < count; ++i) {
      tasks[begin + i].estimate.radiance += results[i].radiance;
      tasks[begin + i].estimate.rays += results[i].rays;
    }
  }
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
