// A program is compiled once, whatever ran before it: a software device would compile it again for each state of
// its texture slots (Renderer::Impl::settle_slots).
#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>

#include "render/gl/context.h"
#include "render/renderer.h"
#include "scenes/environment.h"
#include "scenes/scene.h"

namespace maquette {
namespace {

double cpu_ms(const FrameStats& stats, const std::string& name) {
  for (const PassTime& pass : stats.passes)
    if (pass.name == name) return pass.cpu_ms;
  return 0.0;
}

TEST(TextureSlots, AFrameAfterOthersCompilesNothing) {
  setenv("MESA_SHADER_CACHE_DISABLE", "true", 1);  // before the context is created, so that compilation is not cached
  const GlContext context = GlContext::create_headless();
  if (!query_device().software) GTEST_SKIP() << "other drivers compile a program once";
  install_debug_output();
  Renderer renderer;
  renderer.set_environment(std::make_shared<Environment>(load_environment("builtin:clear-sky")));
  renderer.set_scene(std::make_shared<Scene>(load_scene("builtin:sphere")));
  FrameRequest request;
  request.mode = "bandwidth";
  request.width = 64;
  request.height = 48;
  request.samples = 4;
  request.camera.eye = {0.0f, 0.0f, 4.0f};
  request.settings.set_from_text("shading.visibility", "none");
  request.settings.set_from_text("shading.reuse", "false");
  const FrameStats first = renderer.render(request);
  renderer.render(request, true);
  renderer.render(request, true);  // other programs: what was measured
  FrameRequest uniform = request;
  uniform.mode = "uniform";
  renderer.render(uniform);
  const FrameStats again = renderer.render(request);
  for (const char* pass : {"gbuffer", "bandwidth", "upsample"})
    EXPECT_LT(cpu_ms(again, pass), 0.3 * cpu_ms(first, pass)) << pass;
  EXPECT_TRUE(take_gl_errors().empty());
}

}  // namespace
}  // namespace maquette
