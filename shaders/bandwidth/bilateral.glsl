// Bilateral weight of a coarse neighbour for a point: distance from the tangent plane, normal, material.
#include "shared/bindings.glsl"
struct Guide {
  vec3 position;  // m, relative to the eye
  vec3 normal;
  int material;
  float pixel_m;  // width of a pixel at this depth
  float open;  // visibility of the sky in the mirror direction (sky_visibility.comp); 1 in shaders that do not read it
  bool valid;
};

layout(binding = kUnitGuide) uniform usampler2D t_guide;

Guide load_guide(ivec2 pixel) {
  uvec2 packed_guide = texelFetch(t_guide, pixel, 0).xy;
  float depth = uintBitsToFloat(packed_guide.x);
  Guide g;
  g.valid = depth > 0.0;
  g.position = position_through(vec2(pixel) + 0.5, depth);
  g.normal = guide_normal(packed_guide.y);
  g.material = int(packed_guide.y >> 24u);
  g.pixel_m = pixel_width(depth);
  g.open = 1.0;
  return g;
}

float bilateral_weight(Guide a, Guide b, float step_px) {
  if (!b.valid || a.material != b.material) return 0.0;
  // Distance from the tangent planes in pixels at this depth, relative to the distance between the points in pixels.
  vec3 d = b.position - a.position;
  float off = max(abs(dot(d, a.normal)), abs(dot(d, b.normal))) / max(a.pixel_m * step_px, 1e-20);
  vec3 normal_change = a.normal - b.normal;
  return exp2(-1.5 * off * off - 6.0 * dot(normal_change, normal_change));
}
