// The environment along a grid point's own ray, cd/m2. Needs frame, latlong and rgb9e5 included before.
#include "shading/environment_bilinear.glsl"
vec3 sky_radiance(ivec2 p) {
  return environment_bilinear(environment_from_world(normalize(view_ray(p)))) * u_frame.environment.z;
}
