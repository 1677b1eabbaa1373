#include <gtest/gtest.h>

#include <set>

#include "render/gbuffer/surfaces.h"
#include "render/gl/context.h"
#include "render/gl/program_cache.h"
#include "render/renderer.h"

namespace maquette {
namespace {

/// Whether a word stands in a shader or in what it includes.
bool reads(const ShaderVariant& variant, const char* word) {
  return load_shader_text(variant.path).find(word) != std::string::npos;
}

TEST(ShaderVariants, EveryOneCompiles) {
  const GlContext context = GlContext::create_headless();
  ProgramCache cache;
  // Without and with all that materials may have, and each of it alone.
  for (const MaterialDetails& details :
       {MaterialDetails{}, MaterialDetails{true, true, true, true}, MaterialDetails{true}, MaterialDetails{true, true},
        MaterialDetails{true, false, true}, MaterialDetails{true, false, false, true}}) {
    cache.set_common(shader_defines(details));
    std::set<ShaderVariant> seen;
    for (const ShaderVariant& variant : all_shader_variants()) {
      EXPECT_TRUE(seen.insert(variant).second) << variant.path << " is listed twice";
      // That materials have details at all changes the G-buffer; which ones they have, their lobes.
      const bool all = details.anisotropy && details.film && details.coat_normal;
      if (details.any && !reads(variant, all ? "DETAILS" : "ANALYTIC_")) continue;
      EXPECT_NO_THROW(cache.get(variant)) << variant.path;
    }
  }
  const auto errors = take_gl_errors();
  EXPECT_TRUE(errors.empty()) << errors.front();
}

}  // namespace
}  // namespace maquette
