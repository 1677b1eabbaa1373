// Environment radiance (stored units), bilinear between the four texels around. `d` in the environment's frame, unit.
// Needs frame, latlong and rgb9e5 included before.
layout(binding = 14) uniform usamplerBuffer t_environment;  // [height][width], shared exponent

vec3 environment_bilinear(vec3 d) {
  ivec2 size = u_frame.environment_size.xy;
  vec2 uv = latlong_uv_from_direction(d) * vec2(size) - 0.5;
  ivec2 p = ivec2(floor(uv));
  vec2 f = uv - vec2(p);
  vec3 sum = vec3(0.0);
  for (int k = 0; k < 4; ++k) {
    ivec2 q = p + ivec2(k & 1, k >> 1);
    q.x = (q.x + size.x) % size.x;
    q.y = clamp(q.y, 0, size.y - 1);
    float w = ((k & 1) != 0 ? f.x : 1.0 - f.x) * ((k >> 1) != 0 ? f.y : 1.0 - f.y);
    sum += w * unpack_rgb9e5(texelFetch(t_environment, q.y * size.x + q.x).x, u_frame.environment_size.z);
  }
  return sum;
}
