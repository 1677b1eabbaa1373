#include <gtest/gtest.h>

#include <set>

#include "render/gl/context.h"
#include "render/gl/program_cache.h"
#include "render/renderer.h"

namespace maquette {
namespace {

TEST(ShaderVariants, EveryOneCompiles) {
  const GlContext context = GlContext::create_headless();
  ProgramCache cache;
  std::set<ShaderVariant> seen;
  for (const ShaderVariant& variant : all_shader_variants()) {
    EXPECT_TRUE(seen.insert(variant).second) << variant.path << " is listed twice";
    EXPECT_NO_THROW(cache.get(variant)) << variant.path;
  }
  const auto errors = take_gl_errors();
  EXPECT_TRUE(errors.empty()) << errors.front();
}

}  // namespace
}  // namespace maquette
