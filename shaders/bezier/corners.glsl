// Scene triangles and pieces of them, by their corners.
#include "reflections/nearest.glsl"
#include "bezier/project.glsl"
struct Corner {
  vec3 world;
  Projected v;
};

bool beyond(vec2 a, vec2 b, int axis) {
  return min(a[axis], b[axis]) > u_window[axis + 2] || max(a[axis], b[axis]) < u_window[axis];
}
bool beyond(Corner a, Corner b) { return beyond(a.v.x, b.v.x, 0) || beyond(a.v.x, b.v.x, 1); }

/// Short edges are straight enough, unless one end has no valid image: then the edge may be longer than it seems.
bool may_bend(Corner a, Corner b, float short_px) {
  if (!a.v.in_front || !b.v.in_front || max(a.v.status, b.v.status) > kReflectionOutside) return true;
  vec2 d = a.v.at - b.v.at;
  return dot(d, d) > short_px * short_px;
}

/// True if no reflection of the triangle can be in the picture.
bool shows_nothing(Corner c[3], float margin_px) {
  if (c[0].v.status == kReflectionBehind && c[1].v.status == kReflectionBehind && c[2].v.status == kReflectionBehind) return true;
  bool in_front = c[0].v.in_front && c[1].v.in_front && c[2].v.in_front;
  for (int k = 0; k < 2; ++k) {
    vec3 x = vec3(c[0].v.x[k], c[1].v.x[k], c[2].v.x[k]);
    if (min(min(x.x, x.y), x.z) > u_window[k + 2] || max(max(x.x, x.y), x.z) < u_window[k]) return true;
    if (!in_front) continue;
    vec3 at = vec3(c[0].v.at[k], c[1].v.at[k], c[2].v.at[k]);
    if (min(min(at.x, at.y), at.z) > float(u_frame.size[k]) + margin_px || max(max(at.x, at.y), at.z) < -margin_px) return true;
  }
  return false;
}

/// Under a quadratic map the inside of a triangle deviates by at most this many times the largest deviation of its edges.
const float kBulge = 1.5;

/// Offers the triangle for the pixels where it may be seen. `margin_px`: how far its image may extend beyond the triangle of its corners.
void offer_corners(Corner c[3], float margin_px, int triangle) {
  uint own = offered(triangle, max(max(c[0].v.steps, c[1].v.steps), c[2].v.steps));
  vec3 d = c[1].world - c[0].world, e = c[2].world - c[1].world, f = c[0].world - c[2].world;
  // A point of the triangle is at most 0.58 edges away from a corner, and its reflection point moves by no more.
  float longest = sqrt(max(max(dot(d, d), dot(e, e)), dot(f, f)));
  float nearest_m = min(min(c[0].v.along_m, c[1].v.along_m), c[2].v.along_m) - 1.2 * longest;
  nearest_m -= 2.0 * ghost_offset(max(nearest_m, 0.0) + 2.0 * longest);
  if (c[0].v.in_front && c[1].v.in_front && c[2].v.in_front)
    offer_triangle(c[0].v.at, c[1].v.at, c[2].v.at, margin_px, nearest_m, own, u_reflector);
  else
    offer_triangle(vec2(0.0), vec2(u_frame.size.xy), vec2(0.0), kBoxOnly, nearest_m, own, u_reflector);
}
