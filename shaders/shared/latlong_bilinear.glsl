// Bilinear lookup in a latitude-longitude map: longitude wraps, poles clamp. Common subset of GLSL and C++ with GLM. The includer defines
// before it:
//   vec3 fetch_latlong(int x, int y)   texel of the map
// `uv` in [0, 1]^2 (shared/latlong.glsl).
vec3 latlong_bilinear(vec2 uv, ivec2 size) {
  float px = uv.x * float(size.x) - 0.5f;
  float py = uv.y * float(size.y) - 0.5f;
  int x0 = int(floor(px));
  int y0 = int(floor(py));
  float fx = px - float(x0);
  float fy = py - float(y0);
  int left = x0 < 0 ? x0 + size.x : x0;
  int right = x0 + 1 >= size.x ? x0 + 1 - size.x : x0 + 1;
  int top = clamp(y0, 0, size.y - 1);
  int bottom = clamp(y0 + 1, 0, size.y - 1);
  vec3 upper = fetch_latlong(left, top) * (1.0f - fx) + fetch_latlong(right, top) * fx;
  vec3 lower = fetch_latlong(left, bottom) * (1.0f - fx) + fetch_latlong(right, bottom) * fx;
  return upper * (1.0f - fy) + lower * fy;
}
