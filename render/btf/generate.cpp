#include "render/btf/generate.h"

#include <algorithm>
#include <cassert>
#include <numeric>

#include "scenes/btf/btf_values.h"
#include "scenes/btf/factorise.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

/// Texels whose images are written at once: each light's image is a row far from the others.
constexpr std::size_t kTexelsABlock = 32;
/// Share of the time until the first view, for progress.
constexpr double kLightShare = 0.3;

}  // namespace

std::vector<float> trace_btf_view(const SmallGeometry& geometry, const TileRays& rays, const SmallScaleLight& light,
                                  const glm::dvec3& view, int texels, double* shadowed) {
  assert(geometry.side % texels == 0);
  const auto side = static_cast<std::size_t>(texels), count = light.light_count(), all = side * side;
  const int cells = geometry.side / texels;
  const float share = 1.0f / static_cast<float>(cells * cells);
  const glm::vec3 wo(view);
  std::vector<float> images(count * all * 3);
  std::vector<std::size_t> dark((all + kTexelsABlock - 1) / kTexelsABlock, 0);
  parallel_for(std::size_t{0}, dark.size(), [&](std::size_t block) {
    const std::size_t begin = block * kTexelsABlock, end = std::min(all, begin + kTexelsABlock);
    std::vector<glm::vec3> sums((end - begin) * count, glm::vec3(0.0f));
    for (std::size_t t = begin; t < end; ++t)
      for (int k = 0; k < cells * cells; ++k) {
        const float x = static_cast<float>(static_cast<int>(t % side) * cells + k % cells) + 0.5f;
        const float y = static_cast<float>((texels - 1 - static_cast<int>(t / side)) * cells + k / cells) + 0.5f;
        const std::uint32_t cell = rays.seen_cell(glm::vec2(x, y) / static_cast<float>(geometry.side), wo);
        if (cell == TileRays::kNone) continue;
        light.add_radiance(cell, wo, share, &sums[(t - begin) * count]);
        for (std::size_t l = 0; shadowed && l < count; ++l) dark[block] += light.lit(cell, l) ? 0 : 1;
      }
    for (std::size_t l = 0; l < count; ++l) {
      const float of_irradiance = 1.0f / light.light(l).z;
      float* out = &images[(l * all + begin) * 3];
      for (std::size_t t = 0; t < end - begin; ++t)
        for (int c = 0; c < 3; ++c) *out++ = sums[t * count + l][c] * of_irradiance;
    }
  });
  if (shadowed)
    *shadowed += static_cast<double>(std::accumulate(dark.begin(), dark.end(), std::size_t{0})) * share /
                 static_cast<double>(all * count);
  return images;
}

Btf generate_btf(const std::string& name, const SmallGeometry& geometry, const BtfGeneratorOptions& options,
                 const BtfTask& task) {
  const std::string what = "tracing " + name;
  task.report(what, 0.0);
  const TileRays rays(geometry);
  const SmallScaleLight light(geometry, rays, options.lights, options.light, task);
  Btf btf;
  btf.name = name;
  btf.width = btf.height = options.texels;
  btf.components = options.components;
  btf.texel_m = options.tile_m / options.texels;
  const BtfLights lights = make_btf_lights(options.lights);
  double shadowed = 0.0;
  for (const glm::dvec3& view : options.views) {
    task.check(name);
    const double done = static_cast<double>(btf.views.size()) / static_cast<double>(options.views.size());
    task.report(what, kLightShare + (1.0 - kLightShare) * done);
    std::vector<float> images = trace_btf_view(geometry, rays, light, view, options.texels, &shadowed);
    btf.views.push_back(factorise_btf_view(view, lights, options.components, &images));
  }
  btf.provenance = {{"source", "builtin:" + name},
                    {"btf.cosine", "false"},
                    {"btf.gamma", "1"},
                    {"texel", "of the made geometry"},
                    {"shadowed_share", btf_number(shadowed / static_cast<double>(options.views.size()))},
                    {"gather_rays", std::to_string(options.light.gather_rays)}};
  complete_btf(&btf);
  task.report(what, 1.0);
  return btf;
}

}  // namespace maquette
