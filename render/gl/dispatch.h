#pragma once

#include "render/gl/objects.h"

namespace maquette {

/// Groups of `size` that hold `count` invocations.
constexpr int group_count(int count, int size) { return (count + size - 1) / size; }

/// Runs a compute program and waits, on the device, for all that it writes.
void dispatch(const Program& program, int groups_x, int groups_y);
/// As many groups as needed for `count` invocations of 64, folded as shaders/shading/linear_id.glsl unfolds them.
void dispatch_list(const Program& program, int count);
/// With group counts that a shader wrote at `offset` bytes into the bound GL_DISPATCH_INDIRECT_BUFFER.
void dispatch_indirect(const Program& program, std::ptrdiff_t offset);

}  // namespace maquette
