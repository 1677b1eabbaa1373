#include "render/gl/raster_state.h"

namespace maquette {

void begin_triangles(GLuint framebuffer, int width, int height) {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, width, height);
  const GLuint none[4] = {0, 0, 0, 0};
  const float far_depth = 0.0f;
  glClearNamedFramebufferuiv(framebuffer, GL_COLOR, 0, none);
  glClearNamedFramebufferfv(framebuffer, GL_DEPTH, 0, &far_depth);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_CLIP_DISTANCE0);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  glFrontFace(GL_CCW);  // GL_UPPER_LEFT keeps the winding of the file
  glCullFace(GL_BACK);
}

void end_triangles() {
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_CLIP_DISTANCE0);
  glDisable(GL_CULL_FACE);
}

}  // namespace maquette
