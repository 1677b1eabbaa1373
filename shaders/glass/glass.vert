// Panes and blended surfaces. Computes per vertex the visibility of the sky in the mirror direction, which varies slowly.
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/octahedral.glsl"
layout(location = 0) in vec3 a_position;
#include "gbuffer/vertex.glsl"
#if TEXTURES
out vec4 v_uv;  // of both sets
out vec4 v_tangent;
#endif
#if VISIBILITY == 2
#include "octree/tables.glsl"
#elif VISIBILITY
#include "shared/visibility.glsl"
layout(binding = kUnitVisibility) uniform usamplerBuffer t_visibility;  // [vertex][side of +n, of -n][kVisibilityWords]
#endif
out vec3 v_position;  // m, from where its ray starts
out vec3 v_normal;
out vec4 v_color;
out float v_open;     // share of the mirror direction that is not occluded

#if VISIBILITY == 1
float open_share(vec3 direction, bool back) {
  VisibilityCorner corner = visibility_corner(direction);
  VisibilityBitPosition place = visibility_bit_position(corner.lower);
  uint word = texelFetch(t_visibility, kVisibilityWords * (2 * gl_VertexID + (back ? 1 : 0)) + place.word).x;
  return dot(visibility_shares(corner.fraction), visibility_bits(word, place.shift));
}
#endif

void main() {
  gl_Position = u_frame.clip_from_world * vec4(a_position, 1.0);
  gl_ClipDistance[0] = u_frame.section.w - dot(u_frame.section.xyz, a_position);
  v_position = from_eye(a_position);
  v_normal = texelFetch(t_vertices, 4 * gl_VertexID + 1).xyz;
  v_color = vertex_color(gl_VertexID);
#if TEXTURES
  v_tangent = texelFetch(t_vertices, 4 * gl_VertexID + 2);
  v_uv = vec4(vertex_uv0(gl_VertexID), vertex_uv1(gl_VertexID));
#endif
  v_open = 1.0;
#if VISIBILITY
  bool back = dot(v_normal, v_position) > 0.0;
  vec3 n = back ? -v_normal : v_normal;
  vec3 mirrored = reflect(normalize(v_position), n);
#endif
#if VISIBILITY == 1
  v_open = open_share(mirrored, back);
#elif VISIBILITY == 2
  // The octree does not contain the pane, but it contains the frame around it.
  float own_m = 2.0 * octree_cell_at(octree_frame(), a_position) / u_octree.w;
  OctreeHit hit = octree_trace(octree_frame(), OctreeRay(a_position, mirrored, own_m, 1e30, 0.0, 0.0, 0.0));
  v_open = hit.node >= 0 ? 0.0 : 1.0;
#endif
}
