#include "render/reflections/raster.h"

#include "render/camera.h"

namespace maquette {

namespace {

const ShaderVariant kPlanar{"reflections/planar.frag", "reflections/planar.vert", {}};

glm::mat4 mirror_in(const glm::vec4& plane) {
  const glm::vec3 n(plane);
  glm::mat4 m(1.0f);
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) m[c][r] -= 2.0f * n[r] * n[c];
  m[3] = glm::vec4(-2.0f * plane.w * n, 1.0f);
  return m;
}

/// Lower and upper corner of what is seen of the bounds, in clip space's -1 to 1; all of it where they reach around the
/// eye.
glm::vec4 window_of(const glm::mat4& clip_from_world, const Bounds& bounds) {
  glm::vec2 low(1.0f), high(-1.0f);
  for (int k = 0; k < 8; ++k) {
    const glm::vec4 clip =
        clip_from_world * glm::vec4(k & 1 ? bounds.max.x : bounds.min.x, k & 2 ? bounds.max.y : bounds.min.y,
                                    k & 4 ? bounds.max.z : bounds.min.z, 1.0f);
    if (clip.w <= 1e-6f) return {-1.0f, -1.0f, 1.0f, 1.0f};
    low = glm::min(low, glm::vec2(clip) / clip.w);
    high = glm::max(high, glm::vec2(clip) / clip.w);
  }
  return {glm::max(low, glm::vec2(-1.0f)), glm::min(high, glm::vec2(1.0f))};
}

/// A clip space whose borders are those of the window.
glm::mat4 through_window(const glm::mat4& clip_from_world, const glm::vec4& window) {
  const glm::vec2 low(window), high(window.z, window.w), scale = 2.0f / glm::max(high - low, glm::vec2(1e-6f));
  const glm::vec2 shift = -0.5f * scale * (low + high);
  glm::mat4 zoom(1.0f);
  zoom[0][0] = scale.x;
  zoom[1][1] = scale.y;
  glm::mat4 out = zoom * clip_from_world;
  for (int column = 0; column < 4; ++column) {
    out[column][0] += shift.x * clip_from_world[column][3];
    out[column][1] += shift.y * clip_from_world[column][3];
  }
  return out;
}

}  // namespace

void ReflectionRaster::begin(const ReflectionTargets& t) {
  if (!vertex_array_) {
    GLuint name = 0;
    glCreateVertexArrays(1, &name);
    vertex_array_ = GlName<VertexArrayTraits>(name);
  }
  if (depth_.width() != t.width || depth_.height() != t.height || attached_ != t.triangle.get()) {
    depth_ = Texture::make_2d("reflected depth buffer", GL_DEPTH_COMPONENT32F, t.width, t.height);
    GLuint framebuffer = 0;
    glCreateFramebuffers(1, &framebuffer);
    framebuffer_ = GlName<FramebufferTraits>(framebuffer);
    attached_ = t.triangle.get();
    glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, attached_, 0);
    glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT1, t.effort.get(), 0);
    glNamedFramebufferTexture(framebuffer, GL_DEPTH_ATTACHMENT, depth_.get(), 0);
    const GLenum both[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    glNamedFramebufferDrawBuffers(framebuffer, 2, both);
  }
  const GLuint none[4] = {0, 0, 0, 0};
  const float far_depth = 0.0f;
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
  glViewport(0, 0, t.width, t.height);
  glDepthMask(GL_TRUE);
  for (int k = 0; k < 2; ++k) glClearNamedFramebufferuiv(framebuffer_.get(), GL_COLOR, k, none);
  glClearNamedFramebufferfv(framebuffer_.get(), GL_DEPTH, 0, &far_depth);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

void ReflectionRaster::draw(const ReflectionTargets& t, const std::function<void()>& draw) const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
  glViewport(0, 0, t.width, t.height);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ZERO);  // the panes' two sources are refused for two attachments, blending or not
  glDisable(GL_CULL_FACE);
  glEnable(GL_CLIP_DISTANCE0);
  draw();
  glBindVertexArray(0);
  glDisable(GL_CLIP_DISTANCE0);
  glDisable(GL_DEPTH_TEST);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

void ReflectionRaster::draw_planar(const ReflectionFrame& frame, std::size_t reflector) const {
  glm::vec4 plane = *(*frame.reflectors)[reflector].plane;
  if (glm::dot(plane, glm::vec4(glm::vec3(frame.constants->eye), 1.0f)) < 0.0f) plane = -plane;
  const glm::mat4 clip_from_world = frame.constants->clip_from_world * mirror_in(plane);
  const Bounds& mirror = frame.buffers->bounds((*frame.reflectors)[reflector].item);
  const glm::mat4 window_from_world =
      through_window(clip_from_world, window_of(frame.constants->clip_from_world, mirror));
  const Program& program = frame.programs->get(kPlanar);
  glProgramUniformMatrix4fv(program.get(), program.location("u_clip_from_world"), 1, GL_FALSE, &clip_from_world[0].x);
  glProgramUniform4fv(program.get(), program.location("u_plane"), 1, &plane.x);
  program.set("u_reflector", static_cast<int>(reflector));
  draw(*frame.targets, [&] {
    glUseProgram(program.get());
    glBindVertexArray(frame.buffers->vertex_array());
    const FlatGeometry& geometry = frame.buffers->geometry();
    for (std::size_t i = 0; i < geometry.items.size(); ++i) {
      if (!(*frame.occluding)[i] || i == (*frame.reflectors)[reflector].item) continue;
      if (!may_be_seen(window_from_world, frame.buffers->bounds(i))) continue;
      const DrawItem& item = geometry.items[i];
      program.set("u_first_triangle", static_cast<int>(item.first_index / 3));
      glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(item.index_count), GL_UNSIGNED_INT,
                     reinterpret_cast<const void*>(static_cast<std::uintptr_t>(item.first_index) * 4));
    }
  });
}

std::vector<ShaderVariant> raster_shader_variants() { return {kPlanar}; }

}  // namespace maquette
