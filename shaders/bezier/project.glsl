// Projects a scene point to where the eye sees it in one patch: the reflection point by Newton's method, the depth from the path length.
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "reflections/reflectors.glsl"
#include "reflections/ghost.glsl"
layout(binding = kUnitPatchNodes) uniform samplerBuffer t_nodes;  // 5 texels a node: render/bezier/projection.cpp writes them
uniform int u_reflector;
uniform int u_patch;
uniform int u_first_node;
uniform int u_node_count;
uniform float u_side;
uniform int u_careful;
uniform int u_unique;  // the convex side
uniform vec4 u_window;  // lower and upper parameters of the part of the patch that is in the picture

struct Projected {
  vec2 at;       // on screen, px
  bool in_front; // of the eye; else `at` is not valid
  vec2 x;        // parameters, [-1, 1] on the patch
  float along_m; // from the reflection point to the object
  float height;  // above the tangent plane, m
  int status;
  int steps;
  bool certified;
};

BezierNode fetch_node(int k) {
  int i = 5 * (u_first_node + k);
  vec4 a = texelFetch(t_nodes, i), b = texelFetch(t_nodes, i + 1), c = texelFetch(t_nodes, i + 2), d = texelFetch(t_nodes, i + 3);
  vec4 e = texelFetch(t_nodes, i + 4);
  BezierNode node;
  node.position = a.xyz;
  node.height = a.w;
  node.normal = b.xyz;
  node.side = b.w;
  node.dual_x = c.xyz;
  node.dual_y = d.xyz;
  node.x = vec2(c.w, d.w);
  node.direction = e.xyz;
  node.inverse_focus = e.w;
  return node;
}

vec3 reflector_eye() { return u_frame.eye.xyz - u_patches[u_patch].origin.xyz; }

BezierStart find_start(vec3 p) {
  vec3 eye = reflector_eye();
  BezierStart start = no_start(u_side);
  for (int k = 0; k < u_node_count; ++k) start = consider_node(start, fetch_node(k), eye, p);
  start.certified = start.certified || u_unique == 1;
  return start;
}

const float kImageTolerance = 1e-3;  // sine of the largest error of the law of reflection

Projected to_screen(ReflectionPoint r, bool certified) {
  vec4 clip = u_frame.clip_from_world * vec4(r.position + u_patches[u_patch].origin.xyz, 1.0);
  Projected v;
  v.in_front = clip.w > 1e-6;
  v.at = (0.5 * vec2(clip.x, -clip.y) / clip.w + 0.5) * vec2(u_frame.size.xy);
  v.x = r.x;
  v.along_m = r.length_m - length(r.position - reflector_eye());
  v.height = r.height;
  // A stationary path that is not a minimum is an image too, and where the law of reflection nearly holds its position is known.
  v.status = r.status == kReflectionLost && r.residual < kImageTolerance ? kReflectionInside : r.status;
  // The second image's ray may hit a point slightly behind the tangent plane.
  if (v.status == kReflectionBehind && v.height > -ghost_offset(v.along_m)) v.status = kReflectionOutside;
  v.steps = r.steps;
  v.certified = certified;
  return v;
}

Projected project_from(vec3 world, BezierStart start) {
  vec3 p = world - u_patches[u_patch].origin.xyz;
  return to_screen(reflection_point(load_patch(u_patch), reflector_eye(), p, start, u_careful == 1), start.certified);
}

/// Derivative of the position on screen by the object's position; its reflection point is at x. Rows of px/m.
mat2x3 screen_derivative(vec3 p, vec2 x) {
  BezierSurface s = load_patch(u_patch);
  ReflectionDerivative d = reflection_derivative(s, reflector_eye(), p, x);
  SurfaceJet jet = bezier_jet(s, x);
  vec4 clip = u_frame.clip_from_world * vec4(jet.p + u_patches[u_patch].origin.xyz, 1.0);
  vec4 cx = u_frame.clip_from_world * vec4(jet.dx, 0.0), cy = u_frame.clip_from_world * vec4(jet.dy, 0.0);
  vec2 scale = 0.5 * vec2(u_frame.size.x, -u_frame.size.y) / clip.w, ndc = clip.xy / clip.w;
  vec2 by_x = scale * (cx.xy - ndc * cx.w), by_y = scale * (cy.xy - ndc * cy.w);
  return mat2x3(by_x.x * d.x + by_y.x * d.y, by_x.y * d.x + by_y.y * d.y);
}

/// Largest distance in pixels between the second image of a point and its first.
float ghost_shift(vec3 by_x, vec3 by_y, float along_m) {
  return kGhostSlack * ghost_offset(along_m) * sqrt(dot(by_x, by_x) + dot(by_y, by_y));
}

/// Projects from a near start: a few steps, one attempt.
Projected project_near(vec3 world, vec2 x, int steps) {
  vec3 p = world - u_patches[u_patch].origin.xyz;
  return to_screen(reflect_from(load_patch(u_patch), reflector_eye(), p, clamp(x, -kParameterLimit, kParameterLimit), kParameterLimit, steps), false);
}
