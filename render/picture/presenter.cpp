#include "render/picture/presenter.h"

#include <cmath>

#include "render/gl/bindings.h"
#include "render/gl/dispatch.h"

namespace maquette {

ShaderVariant present_variant(int side) {
  return {"present/present.frag", "present/present.vert", {{"SIDE", std::to_string(side)}}};
}

void present(const Texture& picture, const glm::ivec4& rectangle, const PresentRule& rule, ProgramCache* programs) {
  const Program& program = programs->get(present_variant(rule.side));
  program.set("u_exposure", std::exp2(rule.exposure_ev));
  program.set("u_curve", rule.curve);
  // Window coordinates put row 0 at the bottom, whatever the clip origin of the G-buffer pass.
  glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
  program.set("u_flip", 1);
  glViewport(rectangle.x, rectangle.y, rectangle.z, rectangle.w);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glBindTextureUnit(kUnitPicture, picture.get());
  GLuint empty = 0;
  glCreateVertexArrays(1, &empty);
  const GlName<VertexArrayTraits> vertex_array(empty);
  glBindVertexArray(empty);
  glUseProgram(program.get());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glBindVertexArray(0);
}

void TextureSlots::settle(ProgramCache* programs) {
  if (!texture_) {
    const float zero = 0.0f;
    texture_ = Texture::make_2d("slots", GL_R32F, 1, 1);
    texture_.upload(0, 1, 1, GL_RED, GL_FLOAT, &zero);
  }
  glBindTextureUnit(0, texture_.get());
  glBindImageTexture(kImageNever, texture_.get(), 0, GL_FALSE, 0, GL_WRITE_ONLY, GL_R32F);
  dispatch(programs->get(variant()), 1, 1);
}

}  // namespace maquette
