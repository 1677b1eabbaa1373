// The vertex stage of precomputed radiance transfer: for each vertex the light of its three nearest sampled views, by component.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/constants.glsl"
#include "prt/transfer.glsl"
#include "shading/linear_id.glsl"
uniform int u_vertices;
/// [vertex][view][component]: light times the share of the view, with the view's number in w
layout(std430, binding = kBufferTransferShown) writeonly buffer Shown { vec4 b_shown[]; };

void main() {
  int vertex = int(linear_id());
  if (vertex >= u_vertices) return;
  VertexTransfer r = vertex_transfer(vertex, -normalize(from_eye(texelFetch(t_transfer_vertices, 4 * vertex).xyz)));
  for (int v = 0; v < 3; ++v)
    for (int c = 0; c < TERMS; ++c) {
      vec3 light = c == 0 ? r.mean : r.light[v * TERMS + c];
      b_shown[(vertex * 3 + v) * TERMS + c] = vec4(light * r.views.share[v], r.views.share[v] > 0.0 ? float(r.views.index[v]) : -1.0);
    }
}
