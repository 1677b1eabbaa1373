#include "render/reference/worker.h"

#include <algorithm>
#include <utility>

namespace maquette {

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds kBetweenUpdates{250};

/// Every pixel of the coarse picture as a square.
Image magnify(const Image& coarse, int width, int height) {
  Image out(width, height, coarse.channels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int sx = std::min(x * coarse.width / width, coarse.width - 1);
      const int sy = std::min(y * coarse.height / height, coarse.height - 1);
      for (int c = 0; c < coarse.channels; ++c) out.at(x, y, c) = coarse.at(sx, sy, c);
    }
  return out;
}

}  // namespace

void ReferenceWorker::submit(Job job) {
  worker_.submit(std::move(job), [](Job* next, Job&& waiting) {
    // A scene that no one has traced yet must not be forgotten for the camera that moved meanwhile.
    if (next->scene || !waiting.scene) return;
    waiting.picture = next->picture;
    waiting.most_paths = next->most_paths;
    *next = std::move(waiting);
  });
}

void ReferenceWorker::trace(const Job& job, const BackgroundTask<Update>& task) {
  if (job.scene)
    scene_ = build_path_scene({.scene = *job.scene,
                               .environment = job.environment,
                               .variant = job.variant,
                               .geometry = job.geometry.get(),
                               .library = &library_});
  if (!scene_) return;
  const PictureRequest& wanted = job.picture;
  for (const int divisor : {8, 4, 2}) {
    PictureRequest coarse = wanted;
    coarse.width = std::max(wanted.width / divisor, 1);
    coarse.height = std::max(wanted.height / divisor, 1);
    ReferencePicture picture(scene_, coarse);
    if (!picture.add(1, task.stop)) return;
    task.publish({magnify(picture.mean(), wanted.width, wanted.height), 0, 0.0, picture.counts()});
  }
  ReferencePicture picture(scene_, wanted);
  Clock::time_point last;
  while (picture.samples() < job.most_paths) {
    if (!picture.add(1, task.stop)) return;
    if (Clock::now() - last < kBetweenUpdates && picture.samples() < job.most_paths) continue;
    last = Clock::now();
    task.publish({picture.mean(), picture.samples(), picture.relative_error(), picture.counts()});
  }
}

}  // namespace maquette
