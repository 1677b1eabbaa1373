// Attributes of a vertex by its index, of the table that render/scene_state/scene_buffers.cpp writes.
#include "shared/bindings.glsl"
// 4 texels a vertex: position, uv0.x | normal, uv0.y | tangent, w beyond 1.5 where the file gave it | uv1, colour as four half floats
layout(binding = kUnitVertices) uniform samplerBuffer t_vertices;

vec4 unpack_vertex_color(vec2 bits) {
  uvec2 words = floatBitsToUint(bits);
  return vec4(unpackHalf2x16(words.x), unpackHalf2x16(words.y));
}
vec4 vertex_color(int vertex) { return unpack_vertex_color(texelFetch(t_vertices, 4 * vertex + 3).zw); }
vec2 vertex_uv0(int vertex) { return vec2(texelFetch(t_vertices, 4 * vertex).w, texelFetch(t_vertices, 4 * vertex + 1).w); }
vec2 vertex_uv1(int vertex) { return texelFetch(t_vertices, 4 * vertex + 3).xy; }
