// A box along the longest edge of a reflected piece, larger by what the piece may bend.
#include "shared/frame.glsl"
layout(binding = 55) uniform samplerBuffer t_drawn;  // as shaders/bezier/pieces.comp writes it
uniform float u_margin_px;
flat out int v_triangle;
flat out int v_steps;
out gl_PerVertex {
  vec4 gl_Position;
  float gl_ClipDistance[1];
};
void main() {
  int piece = gl_VertexID / 6, k = gl_VertexID - 6 * piece;
  bool right = k == 1 || k == 2 || k == 4, upper = k == 2 || k == 4 || k == 5;
  vec4 a = texelFetch(t_drawn, 4 * piece), b = texelFetch(t_drawn, 4 * piece + 1), c = texelFetch(t_drawn, 4 * piece + 2);
  vec4 rest = texelFetch(t_drawn, 4 * piece + 3);
  vec2 half_size = 0.5 * vec2(u_frame.size.xy), ndc = vec2(right ? 1.0 : -1.0, upper ? 1.0 : -1.0);
  if (min(min(a.w, b.w), c.w) > 0.0) {
    vec2 p = a.xy / a.w * half_size, q = b.xy / b.w * half_size, r = c.xy / c.w * half_size;
    vec2 pq = q - p, qr = r - q, rp = p - r, along = pq;
    if (dot(qr, qr) > dot(along, along)) along = qr;
    if (dot(rp, rp) > dot(along, along)) along = rp;
    along = dot(along, along) > 1e-12 ? normalize(along) : vec2(1.0, 0.0);
    vec2 across = vec2(-along.y, along.x);
    vec3 s = vec3(dot(p, along), dot(q, along), dot(r, along)), t = vec3(dot(p, across), dot(q, across), dot(r, across));
    float x = right ? max(max(s.x, s.y), s.z) + u_margin_px : min(min(s.x, s.y), s.z) - u_margin_px;
    float y = upper ? max(max(t.x, t.y), t.z) + u_margin_px : min(min(t.x, t.y), t.z) - u_margin_px;
    ndc = (x * along + y * across) / half_size;
  }
  gl_Position = vec4(ndc, 0.5, 1.0);
  gl_ClipDistance[0] = 1.0;
  v_triangle = int(rest.w + 0.5) - 1;
  v_steps = int(rest.z + 0.5);
}
