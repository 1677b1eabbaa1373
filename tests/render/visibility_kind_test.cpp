#include "render/visibility/visibility_kind.h"

#include <gtest/gtest.h>

#include "render/bake/bake_runner.h"

namespace maquette {
namespace {

using Worker = BakeWorker<VisibilityJob, DrawnVisibility>;

/// A row of `count` triangles.
VisibilityJob make_job(int count) {
  VisibilityJob job;
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

TEST(VisibilityKind, OnlyTheNewestJobCounts) {
  Worker worker(std::make_shared<VisibilityKind>());
  EXPECT_FALSE(worker.busy());
  EXPECT_FALSE(worker.take());
  for (int count : {2000, 3000, 4}) worker.submit(make_job(count));
  EXPECT_TRUE(worker.busy());
  worker.wait();
  EXPECT_FALSE(worker.busy());
  EXPECT_DOUBLE_EQ(worker.progress(), 1.0);
  const auto bake = worker.take();
  ASSERT_TRUE(bake);
  EXPECT_EQ(bake->value->bake->vertices.size(), 12u);
  EXPECT_EQ(bake->value->sides.size(), 12u);
  EXPECT_FALSE(worker.take());  // once
}

TEST(VisibilityKind, CancelledWorkIsNeverSeen) {
  Worker worker(std::make_shared<VisibilityKind>());
  worker.submit(make_job(2000));
  worker.cancel();
  worker.wait();
  EXPECT_FALSE(worker.busy());
  EXPECT_FALSE(worker.take());
  worker.submit(make_job(3));
  worker.wait();
  EXPECT_TRUE(worker.take());
}

TEST(VisibilityKind, MayGoAwayAtAnyTime) {
  for (int i = 0; i < 20; ++i) {
    Worker worker(std::make_shared<VisibilityKind>());
    worker.submit(make_job(i % 2 ? 1 : 3000));
  }
}

}  // namespace
}  // namespace maquette
