// Many vertices: buffers written in parts, and the refusal of what no buffer holds.
#include <gtest/gtest.h>

#include "render/gl/context.h"
#include "render/prt/buffers.h"
#include "scenes/error.h"
#include "tests/support/small_btf.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

std::shared_ptr<const Transfer> plate_transfer(bool joint) {
  Scene scene;
  scene.materials.push_back(test::matte(glm::vec3(0.5f)));
  test::add(&scene, test::make_grid({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 12, 0), "plate");
  TransferJob job;
  job.geometry = std::make_shared<const FlatGeometry>(flatten(scene));
  job.parts = {{.item = 0}};
  job.materials = {test::small_btf(2, 2)};
  job.occluding = {true};
  job.options = {.faces = 4, .rays = 1, .clusters = 3, .components = 2, .btf_components = 2};
  job.options.joint = joint;
  job.options.texel_clusters = 2;
  job.options.joint_clusters = 2;
  const std::atomic<bool> never{false};
  return bake_transfer(job, {}, nullptr, never, {});
}

TEST(TransferBuffers, SayHowManyVerticesFitWhereTheDriverHoldsFewer) {
  const GlContext context = GlContext::create_headless();
  for (const bool joint : {false, true}) {
    const auto transfer = plate_transfer(joint);
    const std::size_t vertices = transfer->mesh.vertices.size(), records = joint ? 6 : 39;
    ASSERT_EQ(vertices, 169u);
    const auto message = [&](std::size_t texels) -> std::string {
      try {
        const TransferBuffers buffers(*transfer, 288, {texels, 1u << 20});
      } catch (const Error& error) {
        return error.what();
      }
      return "none";
    };
    const std::string told = message(vertices * records - records);  // of one vertex too few
    EXPECT_NE(told.find(" 168 fit"), std::string::npos) << told;
    EXPECT_NE(told.find("of " + std::to_string(16 * records) + " bytes"), std::string::npos) << told;
    EXPECT_EQ(message(1u << 24), "none");
  }
  EXPECT_TRUE(take_gl_errors().empty());
}

TEST(TransferBuffers, AreWrittenInPartsWhereAStorageBufferIsSmall) {
  const GlContext context = GlContext::create_headless();
  const auto transfer = plate_transfer(false);
  const TransferBuffers whole(*transfer, 288, {1u << 24, 1u << 20}), parts(*transfer, 288, {1u << 24, 144 * 50});
  EXPECT_EQ(parts.vertices_at_once(), 48);
  EXPECT_GE(whole.vertices_at_once(), 169);
  for (int first = 0; first < parts.vertices(); first += parts.vertices_at_once()) parts.bind_shown(first);
  EXPECT_TRUE(take_gl_errors().empty());
}

}  // namespace
}  // namespace maquette
