// From a ray and a triangle to a shading frame, for rasterised and traced surfaces.
// Common subset of GLSL and C++ with GLM (render/math/shared_formulas.h).
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

struct EyeRay {
  vec3 origin;     // relative to the eye, m
  vec3 direction;  // not normalised: its parameter is the depth along `forward`
};

// Ray through a point of the picture (ndc, y up). right and up are half the picture at depth 1 m, or of parallel rays everywhere.
// `perspective`: 1, or 0 for parallel rays.
MAQUETTE_FN EyeRay camera_ray(vec3 forward, vec3 right, vec3 up, float perspective, vec2 ndc) {
  vec3 across = right * ndc.x + up * ndc.y;
  EyeRay ray;
  ray.origin = across * (1.0f - perspective);
  ray.direction = forward + across * perspective;
  return ray;
}

struct TriangleHit {
  float depth;
  vec2 barycentric;  // weights of the second and third vertex
};

// Intersection of the ray with the triangle's plane. Source: Moller and Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection", without the
// range tests, which the rasteriser or the ray tracer has done.
MAQUETTE_FN TriangleHit intersect_plane_of_triangle(vec3 origin, vec3 direction, vec3 p0, vec3 e1, vec3 e2) {
  vec3 p = cross(direction, e2);
  float determinant = dot(e1, p);
  float inverse = 1.0f / (abs(determinant) > 1.0e-30f ? determinant : 1.0e-30f);
  vec3 t = origin - p0;
  vec3 q = cross(t, e1);
  TriangleHit hit;
  hit.barycentric = vec2(dot(t, p), dot(direction, q)) * inverse;
  hit.depth = dot(e2, q) * inverse;
  return hit;
}

// Interpolated vertex normal, or the triangle's own where there is none.
MAQUETTE_FN vec3 interpolated_normal(vec3 sum, vec3 geometric) {
  return dot(sum, sum) > 1.0e-20f ? normalize(sum) : normalize(geometric + vec3(0.0f, 1.0e-30f, 0.0f));
}

// `mapped`: the texture's normal in [-1, 1]; `tangent`: interpolated, w the handedness.
MAQUETTE_FN vec3 apply_normal_map(vec3 normal, vec4 tangent, vec3 mapped, float scale) {
  vec3 along = vec3(tangent.x, tangent.y, tangent.z);
  vec3 t = normalize(along - normal * dot(along, normal) + vec3(1.0e-20f, 0.0f, 0.0f));
  vec3 b = cross(normal, t) * (tangent.w < 0.0f ? -1.0f : 1.0f);
  return normalize(t * (mapped.x * scale) + b * (mapped.y * scale) + normal * max(mapped.z, 1.0e-3f));
}

// World direction of a vector in the tangent plane, along tangent and bitangent; across the normal, unit.
MAQUETTE_FN vec3 tangent_direction(vec3 normal, vec4 tangent, vec2 direction) {
  vec3 along = vec3(tangent.x, tangent.y, tangent.z);
  vec3 t = normalize(along - normal * dot(along, normal) + vec3(1.0e-20f, 0.0f, 0.0f));
  vec3 b = cross(normal, t) * (tangent.w < 0.0f ? -1.0f : 1.0f);
  return t * direction.x + b * direction.y;
}

// The visible side is shaded, whether or not the file's normals agree with its winding. Interpolated normals that face away from
// the eye at silhouettes are rotated to grazing. `seen_side`: the triangle's normal towards the eye; `view`: unit, to the eye.
MAQUETTE_FN vec3 face_viewer(vec3 normal, vec3 seen_side, vec3 view) {
  vec3 n = dot(normal, seen_side) < 0.0f ? -normal : normal;
  float facing = dot(n, view);
  return facing < 0.004f ? normalize(n + view * (0.004f - facing)) : n;
}

// Share of a surface's emission that comes through its coat. Source: KHR_materials_clearcoat, "Emission".
MAQUETTE_FN float emission_through_coat(float coat, float cosine) {
  float x = clamp(1.0f - cosine, 0.0f, 1.0f);
  return 1.0f - coat * (0.04f + 0.96f * x * x * x * x * x);
}

struct TangentBasis {
  vec3 t;
  vec3 b;
};

// Branch-free frame about a unit normal. Source: Duff et al. 2017, "Building an Orthonormal Basis, Revisited".
MAQUETTE_FN TangentBasis tangent_basis(vec3 n) {
  float s = n.z >= 0.0f ? 1.0f : -1.0f;
  float a = -1.0f / (s + n.z);
  float c = n.x * n.y * a;
  TangentBasis r;
  r.t = vec3(1.0f + s * n.x * n.x * a, s * c, -s * n.x);
  r.b = vec3(c, s + n.y * n.y * a, -n.y);
  return r;
}
