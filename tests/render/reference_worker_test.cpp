#include <gtest/gtest.h>

#include "render/reference/worker.h"
#include "scenes/environment.h"

namespace maquette {
namespace {

using namespace std::chrono_literals;

ReferenceWorker::Job job_of_sphere() {
  ReferenceWorker::Job job;
  job.scene = std::make_shared<const Scene>(build_builtin_scene("sphere"));
  job.geometry = std::make_shared<const FlatGeometry>(flatten(*job.scene));
  job.environment = std::make_shared<const Environment>(load_environment("builtin:studio"));
  job.picture.width = 32;
  job.picture.height = 18;
  job.picture.camera.eye = {0.0f, 0.0f, 4.0f};
  job.most_paths = 3;
  return job;
}

TEST(ReferenceWorker, EndsWithAllPathsAtTheSizeAskedFor) {
  ReferenceWorker worker;
  EXPECT_FALSE(worker.take(60s));  // nothing to wait for
  worker.submit(job_of_sphere());
  int paths = -1;
  while (const auto news = worker.take(60s)) {
    EXPECT_EQ(news->mean.width, 32);
    EXPECT_EQ(news->mean.height, 18);
    EXPECT_GE(news->paths, paths);
    paths = news->paths;
  }
  EXPECT_EQ(paths, 3);
}

TEST(ReferenceWorker, AnotherCameraKeepsTheSceneEvenOneNotTracedYet) {
  ReferenceWorker worker;
  ReferenceWorker::Job first = job_of_sphere(), moved;
  moved.picture = first.picture;
  moved.picture.width = 20;
  moved.most_paths = 1;
  for (int round = 0; round < 2; ++round) {  // at first the scene may still wait
    if (round == 0) worker.submit(first);
    worker.submit(moved);
    int paths = -1;
    while (const auto news = worker.take(60s)) {
      EXPECT_EQ(news->mean.width, 20);
      paths = news->paths;
    }
    EXPECT_EQ(paths, 1);
  }
}

}  // namespace
}  // namespace maquette
