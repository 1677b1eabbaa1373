// Which clusters may be seen in one patch: the corners of their boxes are projected.
layout(local_size_x = 64) in;
#include "bezier/project.glsl"
layout(std430, binding = 2) readonly buffer Tiles { float b_far_m[]; };  // of 8 x 8 pixels, as reflections/far.comp writes them
layout(std430, binding = 4) writeonly buffer Flags { uint b_in_view[]; };
layout(std430, binding = 5) readonly buffer Starts { vec4 b_starts[]; };  // as bezier/vertices.comp has them
uniform int u_count;

const int kSteps = 6;
/// Of the extent of the corners' images: what lies between them bulges less.
const float kSlack = 0.25;

bool may_be_seen(uint i) {
  vec4 start = b_starts[5u * i], middle = b_starts[5u * i + 3u];
  vec3 by_x = b_starts[5u * i + 1u].xyz, by_y = b_starts[5u * i + 2u].xyz, half_extent = b_starts[5u * i + 4u].xyz;
  vec3 origin = u_reflectors[u_reflector].origin.xyz, first = vec3(0.0);
  vec4 low = vec4(1e30), high = vec4(-1e30);  // px on screen, parameters
  float nearest_m = 1e30, extent_m = 0.0;
  bool behind = true;
  BezierSurface s = load_surface(u_reflector);
  for (int k = 0; k < 8; ++k) {
    vec3 offset = half_extent * (2.0 * vec3(float(k & 1), float(k >> 1 & 1), float(k >> 2)) - 1.0);
    vec2 x = start.xy + clamp(vec2(dot(by_x, offset), dot(by_y, offset)), -0.75, 0.75);
    ReflectionPoint r = reflect_from(s, reflector_eye(), middle.xyz + offset - origin, clamp(x, -kParameterLimit, kParameterLimit), kParameterLimit, kSteps);
    Projected v = place(r, false);
    if (!v.placed || v.status == kReflectionLost || r.residual > 0.01) return true;
    behind = behind && v.status == kReflectionBehind;
    low = min(low, vec4(v.at, v.x));
    high = max(high, vec4(v.at, v.x));
    if (k == 0) first = r.position;
    extent_m = max(extent_m, length(r.position - first));
    nearest_m = min(nearest_m, length(r.position + origin - middle.xyz));
  }
  if (behind) return false;
  vec4 slack = kSlack * (high - low) + vec4(1.0, 1.0, 0.0, 0.0);
  low -= slack;
  high += slack;
  vec2 size = vec2(u_frame.size.xy);
  if (any(greaterThan(low, vec4(size, u_window.zw))) || any(lessThan(high, vec4(0.0, 0.0, u_window.xy)))) return false;
  nearest_m -= middle.w + 0.5 * extent_m;
  ivec2 tiles = (u_frame.size.xy + 7) / 8;
  ivec2 from = ivec2(clamp(low.xy, vec2(0.0), size - 1.0)) / 8, to = ivec2(clamp(high.xy, vec2(0.0), size - 1.0)) / 8;
  for (int y = from.y; y <= to.y; ++y)
    for (int x = from.x; x <= to.x; ++x)
      if (b_far_m[y * tiles.x + x] > nearest_m) return true;
  return false;
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i < uint(u_count)) b_in_view[i] = may_be_seen(i) ? 1u : 0u;
}
