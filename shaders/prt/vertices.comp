// The vertex stage of precomputed radiance transfer: for each vertex the light of its three nearest sampled views, by component.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/constants.glsl"
#include "prt/transfer.glsl"
#include "shading/linear_id.glsl"
uniform int u_first_vertex, u_vertices;  // from the first one, with which the buffer begins, to before the second
/// [vertex][view][component]: light times the share of the view, with the view's number in w; joint form: [vertex][function]
layout(std430, binding = kBufferTransferShown) writeonly buffer Shown { vec4 b_shown[]; };

void main() {
  int at = int(linear_id()), vertex = u_first_vertex + at;
  if (vertex >= u_vertices) return;
  vec3 to_eye = -normalize(from_eye(texelFetch(t_transfer_vertices, 4 * vertex).xyz));
#ifdef JOINT
  uvec2 place = texelFetch(t_transfer_places, vertex).xy;
  uvec4 group = texelFetch(t_transfer_groups, 2 * int(place.y));
  NearViews views = vertex_views(vertex, group, to_eye);
  for (int f = 0; f < int(group.x); ++f) b_shown[at * u_transfer_functions + f] = vec4(function_light(int(place.x), f, views), 1.0);
#else
  VertexTransfer r = vertex_transfer(vertex, to_eye);
  for (int v = 0; v < 3; ++v)
    for (int c = 0; c < TERMS; ++c) {
      vec3 light = c == 0 ? r.mean : r.light[v * TERMS + c];
      b_shown[(at * 3 + v) * TERMS + c] = vec4(light * r.views.share[v], r.views.share[v] > 0.0 ? float(r.views.index[v]) : -1.0);
    }
#endif
}
