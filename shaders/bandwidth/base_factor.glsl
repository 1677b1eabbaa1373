/// In scenes with textures the interpolation works on radiance that is divided by what the base colour makes of it, and compose.comp multiplies by
/// it again. A stored point: rgb, the radiance that a white base would have; w, the luminance of that part of it which the base colour scales
/// (AnalyticLobes::tinted, 0 for what a gloss mirrors). Both are linear in the light, so means of points are points.

/// The base colour that divides; dark ones would only enlarge rounding.
vec3 dividing_base(uvec4 surface) { return max(unpack_base_color(surface.y), vec3(0.004)); }

/// Share of a white base's light that the base colour scales, of a point stored by with_share(). `flags`: of its material.
float tinted_share(vec4 stored, uint flags) {
  if ((flags & kMaterialMeasured) != 0u) return (flags & kMaterialTinted) != 0u ? 1.0 : 0.0;
  return clamp(stored.w / max(luminance(stored.rgb), 1e-30), 0.0, 1.0);
}

/// Factor by which the base colour makes a stored point brighter than a white one.
vec3 base_factor(vec4 stored, uvec4 surface, uint flags) { return mix(vec3(1.0), dividing_base(surface), tinted_share(stored, flags)); }

/// The stored point of a radiance of which that share is scaled.
vec4 with_share(vec3 radiance, uvec4 surface, float share) {
  vec3 white = radiance / mix(vec3(1.0), dividing_base(surface), share);
  return vec4(white, share * luminance(white));
}
