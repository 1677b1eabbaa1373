// The sky before the last rotation of the environment. Directions are in the environment's frame, as everywhere in shading.
uniform vec2 u_rotation;  // cosine and sine of the last turn

/// The direction of the environment that was seen before the rotation in the world direction where `now` is seen after it.
vec3 previous_environment_direction(vec3 now) {
  return vec3(u_rotation.x * now.x + u_rotation.y * now.z, now.y, -u_rotation.y * now.x + u_rotation.x * now.z);
}
/// The inverse: the direction that is seen now in the world direction where `light` was seen before the rotation.
vec3 current_environment_direction(vec3 light) {
  return vec3(u_rotation.x * light.x - u_rotation.y * light.z, light.y, u_rotation.y * light.x + u_rotation.x * light.z);
}

LobeTerms lobe_towards(Point p, vec3 wi, vec2 xi) {
#if MEASURED
  BrdfLookup lookup = brdf_lookup(p.slot, wi, p.wo, xi);
  return lobe_terms(p, wi, fetch_brdf(lookup), lookup.fraction);
#else
  return lobe_terms(p, wi);
#endif
}
