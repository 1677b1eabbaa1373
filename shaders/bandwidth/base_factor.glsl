/// Factor by which its base colour makes a point brighter than neutral grey. In scenes with textures the interpolation works on radiance divided
/// by this factor, and compose.comp multiplies by it again. `surface`: of the G-buffer; `flags`: of its material.
vec3 base_factor(uvec4 surface, uint flags) {
  vec4 y = unpackUnorm4x8(surface.y);
  vec3 c = y.xyz * y.xyz;
  float share = base_color_share(y.w, (flags & kMaterialTinted) != 0u);
  if ((flags & (kMaterialMeasured | kMaterialTinted)) == kMaterialMeasured) share = 0.0;
  return mix(vec3(1.0), max(c, vec3(0.004)), share);
}
