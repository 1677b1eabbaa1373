// Baked visibility of the sky in the mirror direction, at every visible point with a narrow lobe; 1 at other points. Kept until camera, surfaces,
// materials or visibility maps change.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/constants.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/gbuffer.glsl"
layout(binding = kUnitSurface) uniform usampler2D t_surface;
layout(binding = kUnitDepth) uniform sampler2D t_depth;
#include "shared/material_table.glsl"
#include "shared/bandwidth.glsl"
#include "bandwidth/broad.glsl"
#include "bandwidth/bilateral.glsl"
#include "shading/visibility.glsl"
layout(binding = kImageSkyVisibility, r8) uniform writeonly image2D o_sky_visibility;

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  Guide g = load_guide(pixel);
  if (!g.valid) return;
  uvec4 surface = texelFetch(t_surface, pixel, 0);
  uint flags = material_words(int(surface.z >> 16u), 6).x;
  float open = 1.0;
  if (!is_broad(surface, flags, (flags & kMaterialMeasured) != 0u)) {
    VisibilityPoint p = load_visibility(pixel, u_frame.eye.xyz + g.position, g.normal);
    open = mean_visibility(p, reflect(normalize(view_ray(pixel)), p.normal));
  }
  imageStore(o_sky_visibility, pixel, vec4(open));
}
