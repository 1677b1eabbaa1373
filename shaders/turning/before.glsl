// Where the sky stood before the last turn of the light. Directions are in the environment's frame, as everywhere in shading.
uniform vec2 u_turn;  // cosine and sine of the last turn

/// What stood before in the world's direction that `now` is.
vec3 stood_before(vec3 now) {
  return vec3(u_turn.x * now.x + u_turn.y * now.z, now.y, -u_turn.y * now.x + u_turn.x * now.z);
}
/// Today's name of the world's direction in which `light` was seen before.
vec3 seen_before(vec3 light) {
  return vec3(u_turn.x * light.x - u_turn.y * light.z, light.y, u_turn.y * light.x + u_turn.x * light.z);
}

LobeTerms lobe_towards(Point p, vec3 wi, vec2 xi) {
#if MEASURED
  BrdfPlace place = brdf_place(p.slot, wi, p.wo, xi);
  return lobe_terms(p, wi, fetch_brdf(place), place.fraction);
#else
  return lobe_terms(p, wi);
#endif
}
