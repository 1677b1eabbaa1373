// Sampled lights of the scene: filled in below from shared/lights.glsl.
vec3 direct_lights(Point p, ivec2 pixel, uint rotation, uint first_sample) { return vec3(0.0); }
