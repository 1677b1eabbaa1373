// main() of the modes that shade by lookups: the includer defines `vec3 shade(Point p)`, in stored units. Four points an invocation, so that
// one atomic counts four; sixteen invocations a tile.
#include "shared/bindings.glsl"
layout(binding = kImageRadiance, rgba32f) uniform writeonly image2D o_radiance;
layout(binding = kImageLookupMarks, rgba8ui) uniform writeonly uimage2D o_marks;  // shaded, level, log2 of samples, 1 if visible
layout(std430, binding = kBufferCounters) buffer Counters { uint b_visible, b_shaded; };

void main() {
  int id = int(linear_id());
  ivec2 tile = tile_of(id, 4);
  if (tile.x < 0) return;
  uint visible = 0u, shaded = 0u;
  for (int k = 0; k < 4; ++k) {
    // Neighbouring invocations shade neighbouring points.
    ivec2 pixel = kTile * tile + ivec2(id & 7, 2 * k + (id >> 3 & 1));
    if (any(greaterThanEqual(pixel, u_frame.size.xy))) continue;
    if (texelFetch(t_depth, pixel, 0).x <= 0.0) {
      imageStore(o_marks, pixel, uvec4(0u));
      continue;
    }
    ++visible;
    int material = int(texelFetch(t_surface, pixel, 0).z >> 16u);
    bool unlit = (material_words(material, 6).x & kMaterialUnlit) != 0u;
    imageStore(o_marks, pixel, uvec4(unlit ? 0u : 1u, 0u, 0u, 1u));
    if (unlit) continue;  // compose shows its base colour
    ++shaded;
    Point p = load_point(pixel);
    vec3 radiance = shade(p) * (u_frame.environment.z * p.occlusion);
    // A picture never holds NaN or infinity, whatever a fit holds.
    if (any(isnan(radiance)) || any(isinf(radiance))) radiance = vec3(0.0);
    imageStore(o_radiance, pixel, vec4(radiance, 1.0));
  }
  if (visible > 0u) atomicAdd(b_visible, visible);
  if (shaded > 0u) atomicAdd(b_shaded, shaded);
}
