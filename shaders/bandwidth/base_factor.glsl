/// How much brighter a point is for its base colour than the neutral grey that interpolation works in: between points of mode `bandwidth` in a
/// scene with textures, radiance is kept divided by it until the picture is composed. `surface`: of the G-buffer; `flags`: of its material.
vec3 base_factor(uvec4 surface, uint flags) {
  vec4 y = unpackUnorm4x8(surface.y);
  vec3 c = y.xyz * y.xyz;
  float share = base_color_share(y.w, (flags & kMaterialTinted) != 0u);
  if ((flags & (kMaterialMeasured | kMaterialTinted)) == kMaterialMeasured) share = 0.0;
  return mix(vec3(1.0), max(c, vec3(0.004)), share);
}
