// Uses every texture slot of a program and computes nothing: see TextureSlots::settle for the reason.
layout(local_size_x = 1) in;
#include "shared/bindings.glsl"
uniform sampler2D t_slots[32];
layout(binding = kImageNever, r32f) uniform writeonly image2D o_never;

void main() {
  int sum = 0;
  for (int k = 0; k < 32; ++k) sum += textureSize(t_slots[k], 0).x;
  if (sum < 0) imageStore(o_never, ivec2(0), vec4(0.0));
}
