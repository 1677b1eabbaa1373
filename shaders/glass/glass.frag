// Panes: what is behind times the transmittance, plus the mirrored environment times the reflectance; both faces, all bounces between
// them (shared/fresnel.glsl). Thin: the ray is not bent or shifted, and roughness is not seen.
// Blended surfaces: a Lambertian surface of the base colour under the whole sky, covering by alpha.
// Blending is o_color + o_through * (what is there), so that items must come back to front.
#include "shared/frame.glsl"
#include "shared/latlong.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/fresnel.glsl"
#include "shading/environment_bilinear.glsl"
#if TEXTURES
#include "shared/texture_table.glsl"
uniform int u_texture;  // of the base colour, or -1
#endif
layout(binding = 29) uniform sampler2D t_irradiance;  // irradiance over pi, latitude-longitude
uniform vec4 u_base;      // base colour, alpha
uniform vec4 u_emission;  // cd/m2; w: 1 for unlit
uniform vec2 u_pane;      // share that transmits, refractive index; share 0: a blended surface
in vec3 v_position;
in vec3 v_normal;
in vec2 v_uv;
in float v_open;
layout(location = 0, index = 0) out vec4 o_color;
layout(location = 0, index = 1) out vec4 o_through;

/// What a white Lambertian surface shows, in cd/m2.
vec3 white_under_sky(vec3 n) {
  return textureLod(t_irradiance, latlong_uv_from_direction(environment_from_world(n)), 0.0).rgb * u_frame.environment.z;
}

void main() {
  vec4 base = u_base;
#if TEXTURES
  if (u_texture >= 0) {
    vec2 uv = texture_coordinates(u_texture, v_uv, v_uv);
    base *= sample_texture(u_texture, uv, dFdx(uv), dFdy(uv));
  }
#endif
  vec3 view = -normalize(v_position);
  vec3 n = normalize(dot(v_normal, v_normal) > 0.0 ? v_normal : view);
  n = dot(n, view) < 0.0 ? -n : n;
  vec3 surface = u_emission.rgb;
  if (u_pane.x < 1.0) surface += base.rgb * (u_emission.w > 0.0 ? vec3(1.0) : white_under_sky(n) * v_open);
  o_color = vec4(surface * base.a, 0.0);
  o_through = vec4(vec3(1.0 - base.a), 1.0);
  if (u_pane.x > 0.0) {
    float c = dot(n, view);
    vec2 red = fresnel_pane(c, u_pane.y, base.r), green = fresnel_pane(c, u_pane.y, base.g), blue = fresnel_pane(c, u_pane.y, base.b);
    vec3 mirrored = environment_bilinear(environment_from_world(reflect(-view, n))) * (u_frame.environment.z * v_open);
    vec3 reflected = vec3(red.x, green.x, blue.x) * mirrored;
    o_color = vec4(u_emission.rgb + reflected + (1.0 - u_pane.x) * (surface - u_emission.rgb), 0.0);
    o_through = vec4(vec3(red.y, green.y, blue.y) * u_pane.x, 1.0);
  }
}
