// Mean directions and albedos of the lobes of a point's material. Needs shading/point.glsl.
// [slot][64] four texels, in the frame of view and normal (azimuth 0 is the side of the view): albedo, roughness of the specular part | mean
// direction | albedo of the specular part, angle that contains half of it | its mean direction (render/materials/lobes.h)
#include "shared/bindings.glsl"
#include "shared/analytic_albedo.glsl"
layout(binding = kUnitLobes) uniform samplerBuffer t_lobes;

/// A local direction (any length) in the world.
vec3 to_world(Point p, vec3 w) { return world_from_environment(from_local(p, w)); }

struct LobeRow {
  int first;       // texel of the row below the view's elevation
  float fraction;  // of the next one
};
LobeRow lobe_row(Point p) {
  float e = latlong_atan2(p.wo.x, p.wo.z) * (float(kAlbedoEntries - 1) * 0.63661977);
  int i = min(int(e), kAlbedoEntries - 2);
  return LobeRow(4 * (p.slot * kAlbedoEntries + i), e - float(i));
}
vec4 lobe_texel(LobeRow row, int k) {
  return mix(texelFetch(t_lobes, row.first + k), texelFetch(t_lobes, row.first + 4 + k), row.fraction);
}

/// Mean direction of a lobe: between the mirror direction and the one of a Lambertian lobe, which is as wide as the hemisphere.
vec3 lobe_direction(vec3 wo, float alpha) { return mix(vec3(-wo.x, -wo.y, wo.z), vec3(0.0, 0.0, 2.0 / 3.0), alpha); }
