// Boxes that hold the reflections of triangles.
layout(binding = 55) uniform samplerBuffer t_boxes;  // as shaders/triangle/assemble.comp writes them
flat out int v_triangle;
flat out int v_reflector;
flat out int v_root;
out gl_PerVertex {
  vec4 gl_Position;
  float gl_ClipDistance[1];
};
void main() {
  int box = gl_VertexID / 6, k = gl_VertexID - 6 * box;
  vec4 corners = texelFetch(t_boxes, 2 * box), rest = texelFetch(t_boxes, 2 * box + 1);
  bvec2 upper = bvec2(k == 1 || k == 2 || k == 4, k == 2 || k == 4 || k == 5);
  gl_Position = vec4(mix(corners.xy, corners.zw, vec2(upper)), 0.5, 1.0);
  gl_ClipDistance[0] = 1.0;
  v_triangle = int(rest.x + 0.5);
  v_reflector = int(rest.y + 0.5);
  v_root = int(rest.z + 0.5);
}
