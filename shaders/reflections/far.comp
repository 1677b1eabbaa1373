// For each tile of 8 x 8 pixels how far the farthest of what one reflector shows there is: what lies behind cannot be seen.
layout(local_size_x = 64) in;
layout(binding = 50) uniform sampler2D t_ray_direction;  // w: reflector + 1
layout(std430, binding = 9) readonly buffer Nearest { uint b_nearest[]; };  // as reflections/nearest.glsl has them
layout(std430, binding = 2) writeonly buffer Tiles { float b_far_m[]; };    // [row][column]
uniform int u_reflector;

void main() {
  ivec2 size = textureSize(t_ray_direction, 0), tiles = (size + 7) / 8;
  int tile = int(gl_GlobalInvocationID.x);
  if (tile >= tiles.x * tiles.y) return;
  ivec2 low = 8 * ivec2(tile % tiles.x, tile / tiles.x), high = min(low + 8, size);
  float far_m = 0.0;
  for (int y = low.y; y < high.y; ++y) {
    for (int x = low.x; x < high.x; ++x) {
      if (int(texelFetch(t_ray_direction, ivec2(x, y), 0).w) != u_reflector + 1) continue;
      float inverse = uintBitsToFloat(b_nearest[2 * (y * size.x + x) + 1]);
      far_m = max(far_m, inverse > 0.0 ? 1.0 / inverse : 1e30);
    }
  }
  b_far_m[tile] = far_m;
}
