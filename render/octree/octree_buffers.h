#pragma once

#include <cstddef>

#include "render/gl/objects.h"
#include "render/octree/octree.h"

namespace maquette {

/// An octree on the GPU, read through shaders/octree/tables.glsl.
class OctreeBuffers {
 public:
  /// Throws Error when the driver's buffers are too small for it.
  explicit OctreeBuffers(const Octree& octree);
  void bind() const;  ///< units 32 (words), 33 (planes), 34 (colours)
  void bind_triangles() const;
  /// Sets the grid in a program that includes the tables.
  void set_uniforms(const Program& program) const;
  /// Width of cells without much detail.
  float cell_m() const { return static_cast<float>(1 << detail_) / grid_.w; }
  std::size_t bytes() const { return words_.bytes() + planes_.bytes() + colors_.bytes() + triangles_.bytes(); }

 private:
  Buffer words_, planes_, colors_, triangles_;
  Texture word_view_, plane_view_, color_view_, triangle_view_;
  glm::vec4 grid_{0.0f, 0.0f, 0.0f, 1.0f};
  int depth_ = 1, detail_ = 0;
};

}  // namespace maquette
