// The sky before the last rotation of the environment. Directions are in the environment's frame, as everywhere in shading.
uniform vec2 u_turn;  // cosine and sine of the last turn

/// The direction of the environment that was seen before the rotation in the world direction where `now` is seen after it.
vec3 previous_environment_direction(vec3 now) {
  return vec3(u_turn.x * now.x + u_turn.y * now.z, now.y, -u_turn.y * now.x + u_turn.x * now.z);
}
/// The inverse: the direction that is seen now in the world direction where `light` was seen before the rotation.
vec3 current_environment_direction(vec3 light) {
  return vec3(u_turn.x * light.x - u_turn.y * light.z, light.y, u_turn.y * light.x + u_turn.x * light.z);
}

LobeTerms lobe_towards(Point p, vec3 wi, vec2 xi) {
#if MEASURED
  BrdfLookup lookup = brdf_lookup(p.slot, wi, p.wo, xi);
  return lobe_terms(p, wi, fetch_brdf(lookup), lookup.fraction);
#else
  return lobe_terms(p, wi);
#endif
}
