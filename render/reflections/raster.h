#pragma once

#include <optional>

#include "render/reflections/reflector_technique.h"

namespace maquette {

/// Rasterises triangle numbers into `ReflectionTargets::triangle`: what the projecting techniques share.
class ReflectionRaster {
 public:
  /// Makes what the size of the targets needs, and clears it.
  void begin(const ReflectionTargets& targets);
  /// Binds framebuffer and state, calls `draw`, and puts the state back. Clip distance 0 holds.
  void draw(const ReflectionTargets& targets, const std::function<void()>& draw) const;
  /// The scene in one plane mirror, by its mirrored eye: exact.
  void draw_planar(const ReflectionFrame& frame, std::size_t reflector) const;
  /// An array without attributes, for shaders that fetch.
  GLuint vertex_array() const { return vertex_array_.get(); }
  std::size_t bytes() const { return depth_.bytes(); }

 private:
  Texture depth_;
  GlName<FramebufferTraits> framebuffer_;
  GlName<VertexArrayTraits> vertex_array_;
  GLuint attached_ = 0;
};

std::vector<ShaderVariant> raster_shader_variants();

}  // namespace maquette
