// Panes while camera and surfaces rest: the layers that glass.frag recorded at each grid point, from front to back. Only what they mirror is
// looked up anew.
layout(local_size_x = 64) in;
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/latlong.glsl"
#include "shared/rgb9e5.glsl"
#include "shading/environment_bilinear.glsl"
layout(binding = 9) uniform sampler2D t_depth;
layout(binding = 18) uniform usampler2D t_heads;       // number of the nearest layer, 0 for none
layout(binding = 19) uniform usamplerBuffer t_layers;  // as in glass.frag, behind one texel
layout(binding = 0, rgba32f) uniform image2D io_picture;
uniform float u_turn;  // of the environment, in turns
uniform int u_sky;  // 1: the tiles' points that show the sky, 0: those that show a surface

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  uint layer = texelFetch(t_heads, pixel, 0).x;
  if (layer == 0u || (texelFetch(t_depth, pixel, 0).x <= 0.0) != (u_sky == 1)) return;
  vec3 sum = vec3(0.0), through = vec3(1.0);
  while (layer != 0u) {
    int at = 3 * int(layer) - 2;
    uvec4 first = texelFetch(t_layers, at);
    vec4 second = uintBitsToFloat(texelFetch(t_layers, at + 1)), third = uintBitsToFloat(texelFetch(t_layers, at + 2));
    vec2 uv = vec2(fract(uintBitsToFloat(first.y) + u_turn), uintBitsToFloat(first.z));
    vec3 mirrored = latlong_bilinear(uv, u_frame.environment_size.xy) * u_frame.environment.z;
    sum += through * (vec3(uintBitsToFloat(first.w), second.xy) * mirrored + third.yzw);
    through *= vec3(second.zw, third.x);
    layer = first.x;
  }
  vec4 behind = imageLoad(io_picture, pixel);
  imageStore(io_picture, pixel, vec4(sum + through * behind.rgb, behind.w));
}
