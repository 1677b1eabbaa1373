#include "render/visibility/visibility_worker.h"

#include <gtest/gtest.h>

namespace maquette {
namespace {

/// A row of `count` triangles.
VisibilityWorker::Job make_job(int count) {
  VisibilityWorker::Job job;
  DrawItem item;
  for (int i = 0; i < count; ++i) {
    const float x = static_cast<float>(i);
    for (const glm::vec3& p : {glm::vec3(x, 0, 0), glm::vec3(x + 1, 0, 0), glm::vec3(x, 0, -1)}) {
      job.geometry.indices.push_back(static_cast<std::uint32_t>(job.geometry.positions.size()));
      job.geometry.positions.push_back(p);
      job.geometry.normals.emplace_back(0.0f, 1.0f, 0.0f);
    }
  }
  item.index_count = item.vertex_count = static_cast<std::uint32_t>(job.geometry.positions.size());
  job.geometry.items.push_back(item);
  job.transmits.push_back(false);
  return job;
}

TEST(VisibilityWorker, OnlyTheNewestJobCounts) {
  VisibilityWorker worker;
  EXPECT_FALSE(worker.busy());
  EXPECT_FALSE(worker.take());
  for (int count : {2000, 3000, 4}) worker.submit(make_job(count));
  EXPECT_TRUE(worker.busy());
  worker.wait();
  EXPECT_FALSE(worker.busy());
  EXPECT_DOUBLE_EQ(worker.progress(), 1.0);
  const auto bake = worker.take();
  ASSERT_TRUE(bake);
  EXPECT_EQ(bake->bake.vertices.size(), 12u);
  EXPECT_EQ(bake->sides.size(), 12u);
  EXPECT_FALSE(worker.take());  // once
}

TEST(VisibilityWorker, CancelledWorkIsNeverSeen) {
  VisibilityWorker worker;
  worker.submit(make_job(2000));
  worker.cancel();
  worker.wait();
  EXPECT_FALSE(worker.busy());
  EXPECT_FALSE(worker.take());
  worker.submit(make_job(3));
  worker.wait();
  EXPECT_TRUE(worker.take());
}

TEST(VisibilityWorker, MayGoAwayAtAnyTime) {
  for (int i = 0; i < 20; ++i) {
    VisibilityWorker worker;
    worker.submit(make_job(i % 2 ? 1 : 3000));
  }
}

}  // namespace
}  // namespace maquette
