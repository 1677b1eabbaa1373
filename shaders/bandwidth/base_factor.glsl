/// Factor by which its base colour makes a point brighter than neutral grey. In scenes with textures the interpolation works on radiance divided
/// by this factor, and compose.comp multiplies by it again. `surface`: of the G-buffer; `flags`: of its material.
vec3 base_factor(uvec4 surface, uint flags) {
  vec3 c = unpack_base_color(surface.y);
  float share = base_color_share(unpack_metallic(surface.z), (flags & kMaterialTinted) != 0u);
  if ((flags & (kMaterialMeasured | kMaterialTinted)) == kMaterialMeasured) share = 0.0;
  return mix(vec3(1.0), max(c, vec3(0.004)), share);
}
