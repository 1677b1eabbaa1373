// Tangents of textures whose coordinates the vertices' tangents do not follow. Common subset of GLSL and C++ with GLM
// (render/math/surface_formulas.h).
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

// Tangent of a triangle with edges e1 and e2 along which texture coordinates change by d1 and d2; w: handedness, for a bitangent that points to where
// v falls, as vertices have it (render/scene_state/geometry.cpp). `otherwise`: where the coordinates have no extent.
MAQUETTE_FN vec4 triangle_tangent(vec3 normal, vec3 e1, vec3 e2, vec2 d1, vec2 d2, vec4 otherwise) {
  float area = d1.x * d2.y - d2.x * d1.y;
  if (area == 0.0f) return otherwise;
  float side = area < 0.0f ? -1.0f : 1.0f;
  vec3 along_u = (e1 * d2.y - e2 * d1.y) * side;
  vec3 along_v = (e2 * d1.x - e1 * d2.x) * side;
  float handedness = dot(cross(normal, along_u), along_v) > 0.0f ? -1.0f : 1.0f;
  return vec4(normalize(along_u), handedness);
}
