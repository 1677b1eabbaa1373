// Where several shading modes share a frame: what of an image of triangles belongs to one layer. The triangles themselves, or, DEPTHS, the depths
// of what mirrored rays hit.
layout(local_size_x = 8, local_size_y = 8) in;
#include "shared/bindings.glsl"
layout(binding = kUnitTriangle) uniform usampler2D t_triangle;  // number + 1, 0 for none
layout(binding = kUnitTriangleLayers) uniform usamplerBuffer t_layers;  // [triangle]
uniform int u_layer;
#if DEPTHS
layout(binding = kUnitDepth) uniform sampler2D t_depth;
layout(binding = kImageLayerDepth, r32f) uniform writeonly image2D o_depth;
#else
layout(binding = kImageTriangle, r32ui) uniform writeonly uimage2D o_triangle;
#endif

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, textureSize(t_triangle, 0)))) return;
  uint triangle = texelFetch(t_triangle, pixel, 0).x;
  bool own = triangle != 0u && int(texelFetch(t_layers, int(triangle) - 1).x) == u_layer;
#if DEPTHS
  imageStore(o_depth, pixel, vec4(own ? texelFetch(t_depth, pixel, 0).x : 0.0));
#else
  imageStore(o_triangle, pixel, uvec4(own ? triangle : 0u));
#endif
}
