// How far a coarse neighbour may stand for a point: depth against the tangent plane, normal, material.
struct Guide {
  vec3 position;  // m, relative to the eye
  vec3 normal;
  int material;
  float reach_m;
  bool valid;
};

Guide load_guide(ivec2 pixel) {
  Guide g;
  float depth = texelFetch(t_depth, pixel, 0).x;
  uvec4 s = texelFetch(t_surface, pixel, 0);
  g.valid = depth > 0.0;
  g.position = ray_through(vec2(pixel) + 0.5) * depth;
  g.normal = unpack_normal(s.x);
  g.material = int(s.z >> 16u);
  g.reach_m = depth * u_frame.forward.w;
  return g;
}

float bilateral_weight(Guide a, Guide b, float step_px) {
  if (!b.valid || a.material != b.material) return 0.0;
  // Distance from the tangent planes, in pixels of a point this far away, against the step taken.
  vec3 d = b.position - a.position;
  float off = max(abs(dot(d, a.normal)), abs(dot(d, b.normal))) / max(a.reach_m * step_px, 1e-20);
  float bend = length(a.normal - b.normal);
  return exp2(-1.5 * off * off) * exp2(-6.0 * bend * bend);
}
