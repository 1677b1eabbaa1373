// Regions on screen where the clusters may be seen in one patch, by projecting the corners of their boxes.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "bezier/project.glsl"
layout(std430, binding = kBufferBoxes) writeonly buffer Boxes { vec4 b_boxes[]; };  // as reflections/visible.comp reads them
layout(std430, binding = kBufferPatchStarts) readonly buffer Starts { vec4 b_starts[]; };  // as bezier/vertices.comp has them
uniform int u_count;

const int kSteps = 6;
/// Margin relative to the extent of the corners' images: points between the corners project no farther outside.
const float kSlack = 0.25;

/// Two corners on screen, px; the first is greater than the second where nothing is visible.
vec4 find_rectangle(uint i) {
  vec4 everything = vec4(0.0, 0.0, vec2(u_frame.size.xy)), nothing = vec4(1.0, 1.0, -1.0, -1.0);
  vec4 start = b_starts[5u * i], middle = b_starts[5u * i + 3u];
  vec3 by_x = b_starts[5u * i + 1u].xyz, by_y = b_starts[5u * i + 2u].xyz, half_extent = b_starts[5u * i + 4u].xyz;
  vec3 origin = u_patches[u_patch].origin.xyz;
  vec4 low = vec4(1e30), high = vec4(-1e30);  // px on screen, parameters
  bool behind = true;
  BezierSurface s = load_patch(u_patch);
  for (int k = 0; k < 8; ++k) {
    vec3 offset = half_extent * (2.0 * vec3(float(k & 1), float(k >> 1 & 1), float(k >> 2)) - 1.0);
    vec2 x = start.xy + clamp(vec2(dot(by_x, offset), dot(by_y, offset)), -0.75, 0.75);
    ReflectionPoint r = reflect_from(s, reflector_eye(), middle.xyz + offset - origin, clamp(x, -kParameterLimit, kParameterLimit), kParameterLimit, kSteps);
    Projected v = to_screen(r, false);
    if (!v.in_front || v.status == kReflectionLost || r.residual > 0.01) return everything;
    behind = behind && v.status == kReflectionBehind;
    low = min(low, vec4(v.at, v.x));
    high = max(high, vec4(v.at, v.x));
  }
  vec4 slack = kSlack * (high - low) + vec4(1.0, 1.0, 0.0, 0.0);
  low -= slack;
  high += slack;
  if (behind || any(greaterThan(low.zw, u_window.zw)) || any(lessThan(high.zw, u_window.xy))) return nothing;
  return vec4(low.xy, high.xy);
}

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= uint(u_count)) return;
  vec3 middle = b_starts[5u * i + 3u].xyz, half_extent = b_starts[5u * i + 4u].xyz;
  b_boxes[3u * i] = vec4(middle - half_extent, 0.0);
  b_boxes[3u * i + 1u] = vec4(middle + half_extent, 0.0);
  b_boxes[3u * i + 2u] = find_rectangle(i);
}
