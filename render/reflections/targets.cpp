#include "render/reflections/targets.h"

namespace maquette {

ReflectionTargets make_reflection_targets(int grid_width, int grid_height, int divisor) {
  ReflectionTargets t;
  t.divisor = divisor;
  t.width = (grid_width + divisor - 1) / divisor;
  t.height = (grid_height + divisor - 1) / divisor;
  const int w = t.width, h = t.height;
  t.tiles.interleaved = true;
  t.tiles.tiles = Buffer("reflected tiles", static_cast<std::size_t>((w + kTileSide - 1) / kTileSide) *
                                                static_cast<std::size_t>((h + kTileSide - 1) / kTileSide) * 4);
  t.pane = Texture::make_2d("panes", GL_RG32UI, w, h);
  t.pane_depth = Texture::make_2d("pane depth buffer", GL_DEPTH_COMPONENT32F, w, h);
  GLuint framebuffer = 0;
  glCreateFramebuffers(1, &framebuffer);
  t.pane_framebuffer = GlName<FramebufferTraits>(framebuffer);
  glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, t.pane.get(), 0);
  glNamedFramebufferTexture(framebuffer, GL_DEPTH_ATTACHMENT, t.pane_depth.get(), 0);
  t.ray_origin = Texture::make_2d("ray origins", GL_RGBA32F, w, h);
  t.ray_direction = Texture::make_2d("ray directions", GL_RGBA32F, w, h);
  t.triangle = Texture::make_2d("reflected triangles", GL_R32UI, w, h);
  t.effort = Texture::make_2d("reflection effort", GL_RG8UI, w, h);
  t.focus = Texture::make_2d("focus of mirrored rays", GL_R16F, w, h);
  t.low_confidence = Texture::make_2d("uncertain reflections", GL_R8UI, w, h);
  t.surface = Texture::make_2d("reflected surface", GL_RGBA32UI, w, h);
  t.depth = Texture::make_2d("reflected depth", GL_R32F, w, h);
  t.guide = Texture::make_2d("reflected guide", GL_RG32UI, w, h);
  t.marks = Texture::make_2d("reflected marks", GL_RGBA8UI, w, h);
  t.radiance = Texture::make_2d("reflected radiance", GL_RGBA32F, w, h);
  return t;
}

std::size_t reflection_bytes(const ReflectionTargets& t) {
  std::size_t sum = 0;
  for (const Texture* texture :
       {&t.pane, &t.pane_depth, &t.ray_origin, &t.ray_direction, &t.triangle, &t.effort, &t.focus, &t.low_confidence,
        &t.surface, &t.details, &t.depth, &t.guide, &t.marks, &t.radiance, &t.layers, &t.mean, &t.tint, &t.layer_depth})
    sum += texture->bytes();
  return sum + t.tiles.tiles.bytes();
}

}  // namespace maquette
