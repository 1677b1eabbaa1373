// Frames after the first while nothing moves, mode `bandwidth`: the G-buffer and the prediction stay, every point goes
// on with its own sequence of samples, and the deviations measured so far decide who gets how many.
#include "render/progressive.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "render/renderer_impl.h"

namespace maquette {

namespace {

/// Share of the mean deviation that every point gets on top of its own.
constexpr float kLeastShare = 0.1f;

}  // namespace

Progressive Progressive::make(int grid_width, int grid_height, std::size_t tiles) {
  Progressive p;
  p.mean = Texture::make_2d("accumulated mean", GL_RGBA32F, grid_width, grid_height);
  p.spread = Texture::make_2d("accumulated spread", GL_R32F, grid_width, grid_height);
  p.deviation = Texture::make_2d("measured deviation", GL_R32F, grid_width, grid_height);
  p.sums = Buffer("sums of deviations", tiles * sizeof(glm::vec4));
  p.clear();
  return p;
}

void Progressive::clear() {
  const float zero[4] = {};
  glClearTexImage(mean.get(), 0, GL_RGBA, GL_FLOAT, zero);
  glClearTexImage(spread.get(), 0, GL_RED, GL_FLOAT, zero);
  items = largest = 0.0;
}

RefineRates Renderer::Impl::measure_deviations(const FrameRequest& request) {
  Progressive& p = *progressive;
  FrameTargets& t = *targets;
  glBindTextureUnit(18, p.mean.get());
  glBindTextureUnit(19, p.spread.get());
  glBindTextureUnit(21, t.pyramid.get());
  glBindTextureUnit(23, t.marks.get());
  glBindImageTexture(0, p.deviation.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 1, p.sums.get());
  p.sums.clear_to_zero();
  dispatch_tiles(programs.get({"bandwidth/measure.comp", "", {}}), t.surface_tiles, 0);
  glBindTextureUnit(19, p.deviation.get());
  std::vector<glm::vec4> sums(p.sums.bytes() / sizeof(glm::vec4));
  p.sums.read(0, p.sums.bytes(), sums.data());
  double deviation = 0.0, share = 0.0, largest = 0.0, items = 0.0;
  for (const glm::vec4& s : sums) {
    deviation += s.x;
    share += s.y;
    largest = std::max<double>(largest, s.z);
    items += s.w;
  }
  if (!(deviation > 0.0)) return {};
  // What a frame costs besides its samples grows with the grid, so that is what its samples are measured by.
  const double frame_items = 0.5 * static_cast<double>(t.grid_width()) * t.grid_height() * constants.sampling.x /
                             std::max(constants.sampling.y, 1);
  const double least = kLeastShare * deviation / share;
  const double rate = (items + frame_items) / (deviation + least * share);
  // Light samples come from a list that goes round: drawn anew before the hungriest point sees it twice.
  const double wanted = std::min(rate * (largest + least), p.largest + 4096.0);
  if (wanted * constants.sampling.y > EnvironmentBuffers::kListLength) {
    environment->resample(request.seed * 0x9e3779b9u + static_cast<std::uint32_t>(accumulated));
    light_list_is_first = false;
    p.largest = 0.0;
  } else {
    p.largest = wanted;
  }
  p.items = items;
  return {static_cast<float>(rate), static_cast<float>(least)};
}

}  // namespace maquette
