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
uniform vec4 u_window;  // lower and upper parameters of what the picture shows of the patch

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

const float kPlaced = 1e-3;  // sine of the angle that the law of reflection may be missed by

/// Where the point is drawn: as far behind the pane as the path is long, so that the depth test sorts what is reflected.
/// Source: Mueller et al. 2007, Fig. 11.2.
Projected place(ReflectionPoint r, bool certified) {
  vec3 to = r.position - reflector_eye();
  Projected v;
  v.clip = u_frame.clip_from_world * vec4(u_frame.eye.xyz + to * (r.length / max(length(to), 1e-20)), 1.0);
  v.clip.z = float(min(r.steps, 255));  // see shaders/reflections/projected.vert
  v.x = r.x;
  v.height = r.height;
  // A stationary path that is no minimum is an image too; where the law of reflection all but holds the place is known.
  v.status = r.status == kReflectionLost && r.residual < kPlaced ? kReflectionInside : r.status;
  v.steps = r.steps;
  v.certified = certified;
  return v;
}

Projected project_from(vec3 world, BezierStart start) {
  vec3 p = world - u_reflectors[u_reflector].origin.xyz;
  return place(reflection_point(load_surface(u_reflector), reflector_eye(), p, start, u_careful == 1), start.certified);
}

/// From a start that is near: a few steps, one attempt.
Projected project_near(vec3 world, vec2 x, int steps) {
  vec3 p = world - u_reflectors[u_reflector].origin.xyz;
  return place(reflect_from(load_surface(u_reflector), reflector_eye(), p, clamp(x, -kParameterLimit, kParameterLimit), kParameterLimit, steps), false);
}

// Scene triangles and pieces of them, by their corners.
struct Corner {
  vec3 world;
  Projected v;
};

vec2 on_screen(vec4 clip) { return (0.5 * clip.xy / clip.w + 0.5) * vec2(u_frame.size.xy); }

bool beyond(vec2 a, vec2 b, int axis) {
  return min(a[axis], b[axis]) > u_window[axis + 2] || max(a[axis], b[axis]) < u_window[axis];
}
bool beyond(Corner a, Corner b) { return beyond(a.v.x, b.v.x, 0) || beyond(a.v.x, b.v.x, 1); }

/// Short edges are straight enough; what looks short and is not has its ends on two sides of something.
bool may_bend(Corner a, Corner b, float tolerance_px) {
  if (a.v.clip.w <= 0.0 || b.v.clip.w <= 0.0 || max(a.v.status, b.v.status) > kReflectionOutside) return true;
  vec2 d = on_screen(a.v.clip) - on_screen(b.v.clip);
  return dot(d, d) > 36.0 * tolerance_px * tolerance_px;
}

/// True where no reflection of the triangle can be in the picture.
bool shows_nothing(Corner c[3], float margin_px) {
  if (min(min(c[0].v.status, c[1].v.status), c[2].v.status) == kReflectionBehind && max(max(c[0].v.status, c[1].v.status), c[2].v.status) == kReflectionBehind) return true;
  for (int k = 0; k < 2; ++k) {
    vec3 x = vec3(c[0].v.x[k], c[1].v.x[k], c[2].v.x[k]);
    if (min(min(x.x, x.y), x.z) > u_window[k + 2] || max(max(x.x, x.y), x.z) < u_window[k]) return true;
    vec3 w = vec3(c[0].v.clip.w, c[1].v.clip.w, c[2].v.clip.w);
    if (min(min(w.x, w.y), w.z) <= 0.0) continue;
    vec3 at = vec3(c[0].v.clip[k], c[1].v.clip[k], c[2].v.clip[k]) / w;
    float border = 1.0 + 2.0 * margin_px / float(u_frame.size[k]);
    if (min(min(at.x, at.y), at.z) > border || max(max(at.x, at.y), at.z) < -border) return true;
  }
  return false;
}
