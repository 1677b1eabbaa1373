// Panes while camera and surfaces do not change: the layers that glass.frag recorded at each grid point, from front to back. Only the mirrored
// radiance is looked up again. Needs frame, latlong, rgb9e5 and shading/environment_bilinear included before.
#include "shared/bindings.glsl"
layout(binding = kUnitPaneHeads) uniform usampler2D t_pane_heads;        // number of the nearest layer, 0 for none
layout(binding = kUnitPaneLayers) uniform usamplerBuffer t_pane_layers;  // as in glass.frag, behind one texel
uniform float u_rotation;  // rotation of the environment, in full turns

vec3 through_panes(ivec2 pixel, vec3 behind) {
  vec3 sum = vec3(0.0), through = vec3(1.0);
  uint layer = texelFetch(t_pane_heads, pixel, 0).x;
  do {  // tested at the end, as in shading/integrate.glsl
    if (layer != 0u) {
      int at = 3 * int(layer) - 2;
      uvec4 first = texelFetch(t_pane_layers, at);
      vec4 second = uintBitsToFloat(texelFetch(t_pane_layers, at + 1)), third = uintBitsToFloat(texelFetch(t_pane_layers, at + 2));
      vec2 uv = vec2(fract(uintBitsToFloat(first.y) + u_rotation), uintBitsToFloat(first.z));
      vec3 mirrored = latlong_bilinear(uv, u_frame.environment_size.xy) * u_frame.environment.z;
      sum += through * (vec3(uintBitsToFloat(first.w), second.xy) * mirrored + third.yzw);
      through *= vec3(second.zw, third.x);
      layer = first.x;
    }
  } while (layer != 0u);
  return sum + through * behind;
}
