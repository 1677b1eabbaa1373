// From the triangle of each pane pixel to its mirrored ray. On a patch the true surface is hit, not its triangles.
layout(local_size_x = 8, local_size_y = 8) in;
#include "shared/frame.glsl"
#include "reflections/reflectors.glsl"
layout(binding = 4) uniform usamplerBuffer t_indices;
layout(binding = 5) uniform samplerBuffer t_vertices;
layout(binding = 51) uniform usampler2D t_pane;
layout(binding = 52) uniform sampler2D t_opaque_depth;  // of the whole grid, along the viewing axis
layout(binding = 0, rgba32f) uniform writeonly image2D o_origin;
layout(binding = 1, rgba32f) uniform writeonly image2D o_direction;
layout(binding = 2, r16f) uniform writeonly image2D o_focus;
uniform int u_divisor;

struct PanePoint {
  vec3 position, normal;
  float focus;  // 1/m, of the mirrored ray
};

/// Newton's method for eye + k ray = S(x), from the parameters that the triangles give. Their error is of second order in their size.
PanePoint refine(int reflector, vec2 uv, vec3 ray) {
  BezierSurface s = load_surface(reflector);
  vec3 eye = u_frame.eye.xyz - u_reflectors[reflector].origin.xyz;
  vec2 x = 2.0 * uv - 1.0;
  SurfaceJet jet;
  for (int k = 0; k < 3; ++k) {
    jet = bezier_jet(s, x);
    vec3 miss = eye - jet.p, n = cross(jet.dy, ray);
    float determinant = dot(jet.dx, n);
    if (abs(determinant) < 1e-20 || k == 2) break;
    x += clamp(vec2(dot(miss, n), dot(miss, cross(ray, jet.dx))) / determinant, vec2(-0.2), vec2(0.2));
  }
  vec3 normal = cross(jet.dx, jet.dy), incident = normalize(ray);
  normal = dot(normal, normal) > 0.0 ? normalize(normal) : -incident;
  return PanePoint(jet.p + u_reflectors[reflector].origin.xyz, normal, inverse_focal_distance(jet, eye, reflect(incident, normal)));
}

/// Farthest opaque depth among the grid points that the pixel covers; infinity for the sky.
float opaque_depth(ivec2 pixel) {
  ivec2 size = textureSize(t_opaque_depth, 0);
  float farthest = 0.0;
  for (int k = 0; k < 4; ++k) {
    float d = texelFetch(t_opaque_depth, min(pixel * u_divisor + ivec2(k & 1, k >> 1) * (u_divisor - 1), size - 1), 0).x;
    farthest = max(farthest, d > 0.0 ? d : 1e30);
  }
  return farthest;
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, u_frame.size.xy))) return;
  uvec2 pane = texelFetch(t_pane, pixel, 0).xy;
  vec4 origin = vec4(0.0), direction = vec4(0.0);
  float focus = 0.0;
  if (pane.x != 0u) {
    int triangle = int(pane.x) - 1, reflector = int(pane.y) - 1;
    ivec3 v = 4 * ivec3(texelFetch(t_indices, 3 * triangle).x, texelFetch(t_indices, 3 * triangle + 1).x,
                        texelFetch(t_indices, 3 * triangle + 2).x);
    vec4 p0 = texelFetch(t_vertices, v.x), p1 = texelFetch(t_vertices, v.y), p2 = texelFetch(t_vertices, v.z);
    vec4 n0 = texelFetch(t_vertices, v.x + 1), n1 = texelFetch(t_vertices, v.y + 1), n2 = texelFetch(t_vertices, v.z + 1);
    vec3 ray = ray_through(vec2(pixel) + 0.5), e1 = p1.xyz - p0.xyz, e2 = p2.xyz - p0.xyz;
    // Moller and Trumbore 1997, without the range tests: the rasteriser has made them.
    vec3 q = cross(ray, e2), t = u_frame.eye.xyz - p0.xyz;
    float determinant = dot(e1, q);
    float inverse = 1.0 / (abs(determinant) > 1e-30 ? determinant : 1e-30);
    vec2 b = clamp(vec2(dot(t, q), dot(ray, cross(t, e1))) * inverse, 0.0, 1.0);
    b *= 1.0 / max(1.0, b.x + b.y);
    PanePoint point;
    point.position = p0.xyz + b.x * e1 + b.y * e2;
    point.focus = 0.0;
    point.normal = n0.xyz + b.x * (n1.xyz - n0.xyz) + b.y * (n2.xyz - n0.xyz);
    point.normal = dot(point.normal, point.normal) > 1e-20 ? normalize(point.normal) : normalize(cross(e1, e2) + vec3(0.0, 1e-30, 0.0));
    if (u_reflectors[reflector].origin.w > 0.0)
      point = refine(reflector, vec2(p0.w, n0.w) + b.x * vec2(p1.w - p0.w, n1.w - n0.w) + b.y * vec2(p2.w - p0.w, n2.w - n0.w), ray);
    vec3 incident = normalize(ray);
    if (dot(point.normal, incident) > 0.0) point.normal = -point.normal;
    float depth = dot(point.position - u_frame.eye.xyz, u_frame.forward.xyz);
    // Interpolated normals may lean away at silhouettes: a ray into the pane mirrors nothing.
    vec3 mirrored = reflect(incident, point.normal);
    if (depth > 0.0 && depth < opaque_depth(pixel) && dot(mirrored, mirrored) > 0.5) {
      origin = vec4(point.position, depth);
      direction = vec4(mirrored, float(pane.y));
      focus = point.focus;
    }
  }
  imageStore(o_origin, pixel, origin);
  imageStore(o_direction, pixel, direction);
  imageStore(o_focus, pixel, vec4(focus));
}
