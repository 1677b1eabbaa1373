// Draws a picture on screen. SIDE: points a pixel along each axis of the picture. Each point is tone mapped, and a pixel shows their mean:
// if part of a pixel shows a sky 1,000 times as bright as the rest, the edge would look jagged after tone mapping the mean radiance.
#include "shared/bindings.glsl"
#include "shared/luminance.glsl"
#include "shared/tonemap.glsl"
layout(binding = kUnitPicture) uniform sampler2D t_picture;
uniform float u_exposure;
uniform int u_curve;      // of tonemap.glsl; -1: the picture is display-encoded already
uniform int u_flip;       // 1: window framebuffers have row 0 at the bottom
in vec2 v_uv;
layout(location = 0) out vec4 o_color;
void main() {
  vec2 uv = u_flip != 0 ? vec2(v_uv.x, 1.0 - v_uv.y) : v_uv;
#if SIDE > 1
  ivec2 first = ivec2(uv * vec2(textureSize(t_picture, 0) / SIDE)) * SIDE;
  vec3 sum = vec3(0.0);
  for (int k = 0; k < SIDE * SIDE; ++k)
    sum += tonemap(texelFetch(t_picture, first + ivec2(k % SIDE, k / SIDE), 0).rgb, u_exposure, u_curve);
  o_color = vec4(srgb_encode(sum / float(SIDE * SIDE)), 1.0);
#else
  vec3 c = texture(t_picture, uv).rgb;
  o_color = vec4(u_curve < 0 ? c : srgb_encode(tonemap(c, u_exposure, u_curve)), 1.0);
#endif
}
