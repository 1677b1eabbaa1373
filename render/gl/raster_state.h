#pragma once

#include <epoxy/gl.h>

namespace maquette {

/// Begins to draw triangle numbers (0: none) and depth into a cleared framebuffer of this size. Depth is reversed: 0 is
/// far; what lies beyond the section plane (gl_ClipDistance[0]) is cut off. The caller sets GL_CULL_FACE for each item.
void begin_triangles(GLuint framebuffer, int width, int height);
/// After it, and after other draws of the scene.
void end_triangles();

}  // namespace maquette
