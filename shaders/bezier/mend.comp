// What was drawn without a test of each pixel, held against the pixels' mirrored rays: of the triangles seen at a pixel and around it the
// nearest that the ray meets is shown. Closes the cracks between what is drawn as it is and what is tested (bezier/hit.frag).
layout(local_size_x = 8, local_size_y = 8) in;
#include "reflections/ray_triangle.glsl"
layout(binding = 0) uniform usampler2D t_drawn;  // triangle + 1
layout(binding = 54) uniform sampler2D t_focus;  // 1/m, of the mirrored ray
layout(binding = 0, r32ui) uniform writeonly uimage2D o_triangle;
layout(binding = 1, r8ui) uniform writeonly uimage2D o_doubt;
layout(std430, binding = 3) buffer Counters { uint b_counters[16]; };  // 9: pixels in doubt
uniform uint u_patches;  // bit k: reflector k is a patch
uniform vec3 u_low;      // box of what can be mirrored, m
uniform vec3 u_high;

/// Where the ray has left all that can be mirrored behind.
float exit_distance(vec3 origin, vec3 direction) {
  vec3 d = mix(direction, vec3(1e-20), lessThan(abs(direction), vec3(1e-20)));
  vec3 t = max((u_low - origin) / d, (u_high - origin) / d);
  return max(min(min(t.x, t.y), t.z), 0.0);
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy), size = textureSize(t_drawn, 0);
  if (any(greaterThanEqual(pixel, size))) return;
  vec4 direction = texelFetch(t_ray_direction, pixel, 0);
  uint own = texelFetch(t_drawn, pixel, 0).x, shown = own;
  int reflector = int(direction.w) - 1;
  if (reflector >= 0 && (u_patches >> uint(reflector) & 1u) == 1u) {
    vec3 origin = texelFetch(t_ray_origin, pixel, 0).xyz;
    float nearest = 1e30;
    bool sky = own == 0u;
    for (int k = 0; k < 9; ++k) {
      int around = (k + 4) % 9;  // the pixel's own first
      ivec2 at = clamp(pixel + ivec2(around % 3, around / 3) - 1, ivec2(0), size - 1);
      uint other = texelFetch(t_drawn, at, 0).x;
      bool same_pane = int(texelFetch(t_ray_direction, at, 0).w) == reflector + 1;
      sky = sky || (same_pane && other == 0u);
      if (other == 0u || !same_pane || (k > 0 && other == own)) continue;
      float along_m = distance_to_triangle(origin, direction.xyz, int(other) - 1);
      if (along_m >= 0.0 && along_m < nearest) {
        nearest = along_m;
        shown = other;
      }
    }
    if (nearest == 1e30 && sky) shown = 0u;
    // A shortest path reaches its object before the ray's caustic. What the ray meets beyond it has paths of other kinds, which the search
    // does not look for: whether this is what belongs here is not known.
    float reach = shown != 0u && nearest < 1e30 ? nearest : exit_distance(origin, direction.xyz);
    if (reach * texelFetch(t_focus, pixel, 0).x > 1.0) {
      imageStore(o_doubt, pixel, uvec4(1u));
      atomicAdd(b_counters[9], 1u);
    }
  }
  imageStore(o_triangle, pixel, uvec4(shown));
}
