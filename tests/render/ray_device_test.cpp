#include "render/raytraced/ray_device.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "render/raytraced/ray_scene.h"
#include "scenes/parallel.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

/// Also of a thread that has used TBB for nothing before.
TEST(RayDevice, LoopsAfterABuildKeepDenormals) {
  Scene scene;
  scene.materials.push_back(test::matte(glm::vec3(0.5f)));
  test::add(&scene, test::make_grid({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 200, 0));
  const FlatGeometry geometry = flatten(scene);
  std::atomic<int> flushed{0};
  std::thread([&] {
    const RayScene built = build_ray_scene(geometry, std::vector<bool>(geometry.items.size(), true));
    parallel_for(0, 20000, [&](int) {
      volatile float small = 1e-38f;
      if (!(small * 0.01f > 0.0f)) ++flushed;
    });
  }).join();
  EXPECT_EQ(flushed, 0);
}

}  // namespace
}  // namespace maquette
