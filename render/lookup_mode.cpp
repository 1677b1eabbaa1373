#include "render/lookup_mode.h"

#include "render/renderer_impl.h"
#include "render/sg/shading.h"
#include "render/splitsum/shading.h"

namespace maquette {

const LookupModeInfo* find_lookup_mode(const std::string& name) {
  static const LookupModeInfo kModes[] = {
      {"splitsum", "splitsum/shade.comp", make_splitsum_shading},
      {"sg", "sg/shade.comp", make_sg_shading},
  };
  for (const LookupModeInfo& mode : kModes)
    if (mode.name == name) return &mode;
  return nullptr;
}

void Renderer::Impl::shade_by_lookup(const LookupModeInfo& mode, PassTimer* timer) {
  std::unique_ptr<LookupMode>& resources = lookup_modes[mode.name];
  const bool made = !resources;
  if (made) resources = mode.make(environment->environment());
  resources->update(materials);
  if (made) timer->end("prefilter");
  resources->bind();
  FrameTargets& t = *targets;
  t.counters.clear_to_zero();
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, t.counters.get());
  glBindImageTexture(0, t.radiance.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA32F);
  glBindImageTexture(1, t.marks.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_RGBA8UI);
  dispatch_tiles(programs.get({mode.shader, "", {}}), t.surface_tiles, kLookupLanes);
  unsigned counters[2] = {};
  t.counters.read(0, sizeof counters, counters);
  visible_points = counters[0];
  shaded_points = counters[1];
  shading_samples = 0;
  timer->end("shade");
}

}  // namespace maquette
