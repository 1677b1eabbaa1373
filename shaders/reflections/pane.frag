uniform int u_first_triangle;
uniform int u_reflector;
uniform ivec2 u_quads;  // along u and v of a patch that is drawn by fewer triangles than it has; 0: the triangles are its own
in vec2 v_uv;
layout(early_fragment_tests) in;
layout(location = 0) out uvec2 o_pane;

/// Index of the triangle in tessellate_patch (scenes/bezier_patch.cpp), from the parameters.
int patch_triangle() {
  vec2 at = clamp(v_uv * vec2(u_quads), vec2(0.0), vec2(u_quads) - 0.001);
  ivec2 quad = ivec2(at);
  vec2 f = at - vec2(quad);
  return 2 * (quad.y * u_quads.x + quad.x) + (f.y > f.x ? 1 : 0);
}

void main() {
  int triangle = u_quads.x > 0 ? patch_triangle() : gl_PrimitiveID;
  o_pane = uvec2(uint(u_first_triangle + triangle + 1), uint(u_reflector + 1));
}
