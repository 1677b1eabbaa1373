#include "render/gl/dispatch.h"

#include <algorithm>

namespace maquette {

void dispatch(const Program& program, int groups_x, int groups_y) {
  glUseProgram(program.get());
  glDispatchCompute(static_cast<GLuint>(groups_x), static_cast<GLuint>(groups_y), 1);
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

void dispatch_list(const Program& program, int count) {
  constexpr int kGroupsPerRow = 32768;
  const int groups = group_count(count, 64);
  dispatch(program, std::min(groups, kGroupsPerRow), group_count(groups, kGroupsPerRow));
}

void dispatch_indirect(const Program& program, std::ptrdiff_t offset) {
  glUseProgram(program.get());
  glDispatchComputeIndirect(static_cast<GLintptr>(offset));
  glMemoryBarrier(GL_ALL_BARRIER_BITS);
}

}  // namespace maquette
