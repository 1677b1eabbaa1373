// How far a coarse neighbour may stand for a point: depth against the tangent plane, normal, material.
struct Guide {
  vec3 position;  // m, relative to the eye
  vec3 normal;
  int material;
  float reach_m;
  float open;  // of the sky in the mirror direction, where a shader looks for it: open.comp
  bool valid;
};

layout(binding = 26) uniform usampler2D t_guide;

Guide load_guide(ivec2 pixel) {
  uvec2 packed_guide = texelFetch(t_guide, pixel, 0).xy;
  float depth = uintBitsToFloat(packed_guide.x);
  Guide g;
  g.valid = depth > 0.0;
  g.position = ray_through(vec2(pixel) + 0.5) * depth;
  g.normal = guide_normal(packed_guide.y);
  g.material = int(packed_guide.y >> 24u);
  g.reach_m = depth * u_frame.forward.w;
  g.open = 1.0;
  return g;
}

float bilateral_weight(Guide a, Guide b, float step_px) {
  if (!b.valid || a.material != b.material) return 0.0;
  // Distance from the tangent planes, in pixels of a point this far away, against the step taken.
  vec3 d = b.position - a.position;
  float off = max(abs(dot(d, a.normal)), abs(dot(d, b.normal))) / max(a.reach_m * step_px, 1e-20);
  vec3 bend = a.normal - b.normal;
  return exp2(-1.5 * off * off - 6.0 * dot(bend, bend));
}
