// What the baked masks leave open where a mirror would look, at every visible point whose lobe is narrow enough to tell; 1 at others. Kept while
// camera, surfaces, materials and masks hold.
layout(local_size_x = 64) in;
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/constants.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/gbuffer.glsl"
layout(binding = 8) uniform usampler2D t_surface;
layout(binding = 9) uniform sampler2D t_depth;
#include "shared/material_table.glsl"
#include "shared/bandwidth.glsl"
#include "bandwidth/broad.glsl"
#include "bandwidth/bilateral.glsl"
#include "shading/visibility.glsl"
layout(binding = 0, r8) uniform writeonly image2D o_open;

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
    open = mean_visibility(p, reflect(normalize(g.position), p.normal));
  }
  imageStore(o_open, pixel, vec4(open));
}
