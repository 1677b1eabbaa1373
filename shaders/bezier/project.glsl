// A scene point to where the eye sees it in one patch: the reflection point by Newton's method, the depth from the length of the path.
#include "shared/frame.glsl"
#include "reflections/reflectors.glsl"
layout(binding = 54) uniform samplerBuffer t_nodes;  // 5 texels a node: render/bezier/projection.cpp writes them
uniform int u_reflector;
uniform int u_first_node;
uniform int u_node_count;
uniform float u_side;
uniform int u_careful;
uniform int u_unique;  // the convex side

struct Projected {
  vec4 clip;
  vec2 x;        // parameters, [-1, 1] on the patch
  float height;  // above the tangent plane, m: clipped below 0
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

vec3 reflector_eye() { return u_frame.eye.xyz - u_reflectors[u_reflector].origin.xyz; }

BezierStart find_start(vec3 p) {
  vec3 eye = reflector_eye();
  BezierStart start = no_start(u_side);
  for (int k = 0; k < u_node_count; ++k) start = consider_node(start, fetch_node(k), eye, p);
  start.certified = start.certified || u_unique == 1;
  return start;
}

/// Where the point is drawn: as far behind the pane as the path is long, so that the depth test sorts what is reflected.
/// Source: Mueller et al. 2007, Fig. 11.2.
Projected place(ReflectionPoint r, bool certified) {
  vec3 to = r.position - reflector_eye();
  Projected v;
  v.clip = u_frame.clip_from_world * vec4(u_frame.eye.xyz + to * (r.length / max(length(to), 1e-20)), 1.0);
  v.clip.z = float(min(r.steps, 255));  // see shaders/reflections/projected.vert
  v.x = r.x;
  v.height = r.height;
  v.status = r.status;
  v.steps = r.steps;
  v.certified = certified;
  return v;
}

Projected project_from(vec3 world, BezierStart start) {
  vec3 p = world - u_reflectors[u_reflector].origin.xyz;
  return place(reflection_point(load_surface(u_reflector), reflector_eye(), p, start, u_careful == 1), start.certified);
}

/// The same to the second step of Newton's method: enough to tell how far an edge bends, and to start from.
Projected estimate_near(vec3 world, vec2 x) {
  vec3 p = world - u_reflectors[u_reflector].origin.xyz;
  return place(reflect_from(load_surface(u_reflector), reflector_eye(), p, x, kParameterLimit, 2), false);
}

/// A point between two that are known: started from between theirs.
Projected project_near(vec3 world, vec2 x) {
  BezierStart start = no_start(u_side);
  start.x = x;
  start.shortest = clamp(x, vec2(-1.0), vec2(1.0));
  return project_from(world, start);
}
