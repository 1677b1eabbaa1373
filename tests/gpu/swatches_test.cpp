// Balls of the materials list.
#include "viewer/swatches.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "render/gl/context.h"
#include "tests/scenes/temporary_folder.h"
#include "tests/support/waiting.h"

namespace maquette {
namespace {

using Swatched = test::TemporaryFolder;

/// Mean of the opaque texels, 0 to 255.
glm::vec3 mean_of(unsigned texture) {
  std::vector<std::uint8_t> rgba(static_cast<std::size_t>(Swatches::kSide * Swatches::kSide * 4));
  glGetTextureImage(texture, 0, GL_RGBA, GL_UNSIGNED_BYTE, static_cast<GLsizei>(rgba.size()), rgba.data());
  glm::vec3 sum(0.0f);
  float count = 0.0f;
  for (std::size_t i = 0; i < rgba.size(); i += 4) {
    if (rgba[i + 3] < 255) continue;
    sum += glm::vec3(rgba[i], rgba[i + 1], rgba[i + 2]);
    count += 1.0f;
  }
  return sum / std::max(count, 1.0f);
}

TEST_F(Swatched, TablesFromFilesHaveBallsToo) {
  const GlContext context = GlContext::create_headless();
  const std::string file = path("own.binary"), gone = path("gone.binary");
  save_merl(file, make_builtin_brdf("matte-white"));
  Swatches swatches;
  test::comes_true([&] {
    swatches.update({gone, file});
    return swatches.textures().contains(file) && swatches.textures().contains("builtin:matte-white");
  });
  ASSERT_TRUE(swatches.textures().contains(file));
  ASSERT_TRUE(swatches.textures().contains("builtin:matte-white"));
  EXPECT_FALSE(swatches.textures().contains(gone));
  EXPECT_LT(glm::length(mean_of(swatches.textures().at(file)) - mean_of(swatches.textures().at("builtin:matte-white"))),
            2.0f)
      << "the same table, the same ball";
  EXPECT_GT(mean_of(swatches.textures().at(file)).x, 60.0f);
}

}  // namespace
}  // namespace maquette
