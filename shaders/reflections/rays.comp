// Mirrored ray of each reflector pixel from its triangle. On a patch the exact surface is intersected, not its triangles.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/constants.glsl"
#include "shading/random.glsl"
#include "shared/luminance.glsl"
#include "shared/analytic.glsl"
#include "reflections/reflectors.glsl"
layout(binding = kUnitIndices) uniform usamplerBuffer t_indices;
layout(binding = kUnitVertices) uniform samplerBuffer t_vertices;
layout(binding = kUnitPane) uniform usampler2D t_pane;
layout(binding = kUnitOpaqueDepth) uniform sampler2D t_opaque_depth;  // of the whole grid, along the viewing axis
layout(binding = kImageRayOrigin, rgba32f) uniform writeonly image2D o_origin;
layout(binding = kImageRayDirection, rgba32f) uniform writeonly image2D o_direction;
layout(binding = kImageFocus, r16f) uniform writeonly image2D o_focus;
#if FITTED
layout(binding = kUnitPatchFits) uniform usamplerBuffer t_fits;  // patch + 1, parameters of the corners: of triangles that patches are fitted to
// [patch] how far the fitted patch's ray is from the mesh's at most, m at its origin and m more for each m along it; 4 plus and 4 minus the
// largest and least parameters seen; bits of floats
layout(std430, binding = kBufferFitReach) buffer FitBounds { uint b_fits[]; };
#endif
uniform int u_divisor;
uniform int u_frame_at_rest;  // above 0: the rays of each frame vary over the pixel and over the mirror's lobe
uniform float u_alpha[16];    // GGX alpha of the reflectors
#if GHOST
#include "shared/pane.glsl"
uniform vec2 u_ghost_optics[16];  // refractive index; thickness, m, 0 for a mirror
uniform float u_wedge;            // rad: how much thicker a pane gets upwards
// [reflector] 2: how far the second ray is from the front's at most, m at its origin and m more for each m along it; bits of floats
layout(std430, binding = kBufferGhostReach) buffer GhostBounds { uint b_ghost_bounds[]; };
#endif

struct PanePoint {
  vec3 position, normal;
  float focus;  // 1/m, of the mirrored ray
  vec2 x;       // parameters on the patch
};

/// Newton's method for from + k ray = S(x). It starts from the parameters interpolated over the triangle, whose error is quadratic in its size.
PanePoint refine(int number, vec2 x, vec3 from, vec3 ray, int steps) {
  BezierSurface s = load_patch(number);
  vec3 eye = from - u_patches[number].origin.xyz;
  SurfaceJet jet;
  for (int k = 0; k <= steps; ++k) {
    jet = bezier_jet(s, x);
    vec3 miss = eye - jet.p, n = cross(jet.dy, ray);
    float determinant = dot(jet.dx, n);
    if (abs(determinant) < 1e-20 || k == steps) break;
    x += clamp(vec2(dot(miss, n), dot(miss, cross(ray, jet.dx))) / determinant, vec2(-0.2), vec2(0.2));
  }
  vec3 normal = cross(jet.dx, jet.dy), incident = normalize(ray);
  normal = dot(normal, normal) > 0.0 ? normalize(normal) : -incident;
  // Parallel rays come from far away.
  vec3 source = u_frame.eye.w > 0.0 ? eye : jet.p - 1e9 * incident;
  return PanePoint(jet.p + u_patches[number].origin.xyz, normal, inverse_focal_distance(jet, source, reflect(incident, normal)), x);
}

#if FITTED
/// No patch, or one that would not find what the ray hits: finish.comp then marks the hit as one of low confidence.
const float kNoFocus = 6e4;
/// Largest distance and angle between the ray of the fitted patch and that of the mesh; a search beyond would gain nothing from the patch.
const float kMostOffset_m = 0.02, kMostTurn = 0.25;
const float kSharpest = 20.0;  // 1/m

/// Compares the ray with that of the patch fitted to the triangle and records their largest differences. The patch is used to find what the ray
/// hits, not to change the ray. Returns 1/m of the distance to the caustic.
float compare_with_fit(int triangle, vec2 b, vec3 from, vec3 ray, vec3 origin, vec3 direction) {
  uvec4 record = texelFetch(t_fits, triangle);
  if (record.x == 0u) return kNoFocus;
  int number = int(record.x) - 1;
  vec2 x0 = unpackSnorm2x16(record.y), x1 = unpackSnorm2x16(record.z), x2 = unpackSnorm2x16(record.w);
  PanePoint fitted = refine(number, x0 + b.x * (x1 - x0) + b.y * (x2 - x0), from, ray, 4);
  vec3 incident = normalize(ray), miss = fitted.position - from;
  float offset = length(fitted.position - origin), angle = length(reflect(incident, fitted.normal) - direction);
  // A search that has not converged cannot be compared.
  bool found = length(miss - incident * dot(miss, incident)) < 1e-4 * length(miss);
  if (!found || !(offset < kMostOffset_m) || !(angle < kMostTurn)) return kNoFocus;
  // In a sharp fold every hit is beyond the caustic: its confidence is low in any case, and the search need not cover it.
  if (fitted.focus > kSharpest) return fitted.focus;
  atomicMax(b_fits[6 * number], floatBitsToUint(offset));
  atomicMax(b_fits[6 * number + 1], floatBitsToUint(angle));
  vec4 range = clamp(4.0 + vec4(fitted.x, -fitted.x), 0.0, 8.0);
  for (int k = 0; k < 4; ++k) atomicMax(b_fits[6 * number + 2 + k], floatBitsToUint(range[k]));
  return fitted.focus;
}
#endif

#if GHOST
/// The normal turned towards the eye, at a point near where the pixel's ray hit the pane.
vec3 facing_normal(vec3 normal, vec3 incident) { return dot(normal, incident) > 0.0 ? -normal : normal; }

/// Change of the interpolated normal over an offset in the triangle; 0 where it would be large.
vec3 normal_change(vec3 offset, vec3 e1, vec3 e2, vec3 d1, vec3 d2) {
  float a = dot(e1, e1), c = dot(e1, e2), d = dot(e2, e2), determinant = a * d - c * c;
  if (determinant < 1e-20) return vec3(0.0);
  vec2 right = vec2(dot(offset, e1), dot(offset, e2));
  vec3 change = d1 * ((d * right.x - c * right.y) / determinant) + d2 * ((a * right.y - c * right.x) / determinant);
  return dot(change, change) < 0.01 ? change : vec3(0.0);
}

/// The back face's normal, tilted by the wedge about the pane's horizontal line.
vec3 wedged(vec3 normal) {
  vec3 up = vec3(0.0, 1.0, 0.0) - normal * normal.y;
  return dot(up, up) > 1e-6 ? normalize(normal + u_wedge * normalize(up)) : normal;
}
#endif

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

/// The mirrored ray of one of the normals of a rough mirror's facets.
vec3 varied_mirror(vec3 incident, vec3 normal, float alpha, vec2 u) {
  vec3 side = -incident - normal * dot(-incident, normal);
  vec3 x = dot(side, side) > 1e-12 ? normalize(side) : tangent_basis(normal).t, y = cross(normal, x);
  vec3 seen = vec3(dot(-incident, x), 0.0, max(dot(-incident, normal), 1e-3));
  vec3 facet = sample_ggx_visible(normalize(seen), round_width(alpha), u.x, u.y);
  vec3 mirrored = reflect(incident, facet.x * x + facet.y * y + facet.z * normal);
  return dot(mirrored, normal) > 0.0 ? mirrored : reflect(incident, normal);
}

struct PaneTriangle {
  vec4 p0, p1, p2, n0, n1, n2;  // corners and normals as in t_vertices
};
PaneTriangle load_triangle(int triangle) {
  ivec3 v = 4 * ivec3(texelFetch(t_indices, 3 * triangle).x, texelFetch(t_indices, 3 * triangle + 1).x,
                      texelFetch(t_indices, 3 * triangle + 2).x);
  return PaneTriangle(texelFetch(t_vertices, v.x), texelFetch(t_vertices, v.y), texelFetch(t_vertices, v.z),
                      texelFetch(t_vertices, v.x + 1), texelFetch(t_vertices, v.y + 1), texelFetch(t_vertices, v.z + 1));
}

/// Where an eye ray meets the triangle, or `beyond` (in barycentrics) beside it. Writes its barycentrics and UV.
PanePoint meet(PaneTriangle c, int patch_number, vec3 from, vec3 ray, float beyond, out vec2 b, out vec2 uv) {
  // Moller and Trumbore 1997, without the range tests: the rasteriser has made them.
  vec3 e1 = c.p1.xyz - c.p0.xyz, e2 = c.p2.xyz - c.p0.xyz, q = cross(ray, e2), t = from - c.p0.xyz;
  float determinant = dot(e1, q);
  float inverse = 1.0 / (abs(determinant) > 1e-30 ? determinant : 1e-30);
  b = clamp(vec2(dot(t, q), dot(ray, cross(t, e1))) * inverse, -beyond, 1.0 + beyond);
  b *= 1.0 / max(1.0, (b.x + b.y) / (1.0 + beyond));
  uv = vec2(c.p0.w, c.n0.w) + b.x * vec2(c.p1.w - c.p0.w, c.n1.w - c.n0.w) + b.y * vec2(c.p2.w - c.p0.w, c.n2.w - c.n0.w);
  if (patch_number >= 0) return refine(patch_number, 2.0 * uv - 1.0, from, ray, 2);
  vec3 normal = c.n0.xyz + b.x * (c.n1.xyz - c.n0.xyz) + b.y * (c.n2.xyz - c.n0.xyz);
  normal = dot(normal, normal) > 1e-20 ? normalize(normal) : normalize(cross(e1, e2) + vec3(0.0, 1e-30, 0.0));
  return PanePoint(c.p0.xyz + b.x * e1 + b.y * e2, normal, 0.0, vec2(0.0));
}

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  uvec2 pane = texelFetch(t_pane, pixel, 0).xy;
  vec4 origin = vec4(0.0), direction = vec4(0.0);
  float focus = 0.0;
  if (pane.x != 0u) {
    int triangle = int(pane.x) - 1, reflector = int(pane.y) - 1;
    PaneTriangle corners = load_triangle(triangle);
    vec3 from = view_origin(pixel), ray = view_ray(pixel);
    ivec4 mirror = u_mirrors[reflector];
    PanePoint point;
    vec2 b, uv;
    vec3 incident = vec3(0.0), mirrored = vec3(0.0);
    float normal_side = 1.0, depth = 0.0;
    // Once for the middle of the pixel, which decides what is seen there, and at rest once for another point of it.
    for (int k = 0; k < (u_frame_at_rest > 0 ? 2 : 1); ++k) {
      if (k == 1) {
        if (!(depth > 0.0 && depth < opaque_depth(pixel))) break;
        EyeRay varied = ray_through(vec2(pixel) + numbers_at_rest(pixel, u_frame_at_rest).xy);
        from = u_frame.eye.xyz + varied.origin;
        ray = varied.direction;
      }
      point = meet(corners, mirror.x, from, ray, float(k), b, uv);
      incident = normalize(ray);
      normal_side = dot(point.normal, incident) > 0.0 ? -1.0 : 1.0;
      point.normal *= normal_side;
      mirrored = reflect(incident, point.normal);
      if (k == 1 && u_alpha[reflector] > 0.0)
        mirrored = varied_mirror(incident, point.normal, u_alpha[reflector], numbers_at_rest(pixel + ivec2(8192, 0), u_frame_at_rest).xy);
      if (k == 0) depth = dot(point.position - u_frame.eye.xyz, u_frame.forward.xyz);
    }
    // Interpolated normals may face away at silhouettes; then there is no mirrored ray.
    if (depth > 0.0 && depth < opaque_depth(pixel) && dot(mirrored, mirrored) > 0.5) {
      origin = vec4(point.position, depth);
      direction = vec4(mirrored, float(pane.y));
      focus = point.focus;
#if GHOST
      float n = u_ghost_optics[reflector].x, thickness = u_ghost_optics[reflector].y;
      vec3 back = point.normal, leaving = point.normal;
      GhostRay ghost = pane_ghost(incident, point.normal, wedged(back), leaving, n, thickness);
      // The normal changes over these few millimetres: normals where the back reflects the ray and where the ray leaves.
      vec3 change = normal_change(ghost.offset, corners.p1.xyz - corners.p0.xyz, corners.p2.xyz - corners.p0.xyz, corners.n1.xyz - corners.n0.xyz,
                                 corners.n2.xyz - corners.n0.xyz) * normal_side;
      if (mirror.x >= 0) {
        PanePoint beside = refine(mirror.x, 2.0 * uv - 1.0, from, point.position + ghost.offset - from, 2);
        change = facing_normal(beside.normal, incident) - point.normal;
      }
      back = normalize(point.normal + 0.5 * change);
      leaving = normalize(point.normal + change);
      ghost = pane_ghost(incident, point.normal, wedged(back), leaving, n, thickness);
      origin.xyz += ghost.offset;
      direction = thickness > 0.0 && ghost.valid ? vec4(ghost.direction, float(pane.y)) : vec4(0.0);
      if (direction.w == 0.0) {
        origin = vec4(0.0);
      } else {
        atomicMax(b_ghost_bounds[2 * reflector], floatBitsToUint(length(ghost.offset)));
        atomicMax(b_ghost_bounds[2 * reflector + 1], floatBitsToUint(length(ghost.direction - mirrored)));
      }
#endif
#if FITTED
      if (mirror.y == 1 && direction.w > 0.0) focus = compare_with_fit(triangle + mirror.z, b, from, ray, origin.xyz, direction.xyz);
#endif
    }
  }
  imageStore(o_origin, pixel, origin);
  imageStore(o_direction, pixel, direction);
  imageStore(o_focus, pixel, vec4(focus));
}
