// Environment radiance (stored units), bilinear between the four texels around. `d` in the environment's frame, unit.
// Needs frame, latlong and rgb9e5 included before.
#include "shared/bindings.glsl"
layout(binding = kUnitEnvironment) uniform usamplerBuffer t_environment;  // [height][width], shared exponent

vec3 fetch_latlong(int x, int y) {
  return unpack_rgb9e5(texelFetch(t_environment, y * u_frame.environment_size.x + x).x, u_frame.environment_size.z);
}
#include "shared/latlong_bilinear.glsl"

vec3 environment_bilinear(vec3 d) { return latlong_bilinear(latlong_uv_from_direction(d), u_frame.environment_size.xy); }
