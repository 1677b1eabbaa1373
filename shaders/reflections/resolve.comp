// Intersects the ray of each pixel with the triangles on its tile's list. Neighbouring invocations belong to one tile, so they read the list
// together.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "reflections/ray_triangle.glsl"
#include "reflections/tiles.glsl"
layout(binding = kUnitOfferLists) uniform usamplerBuffer t_lists;  // Lists of reflections/nearest.glsl, counters first
layout(binding = kUnitOffers) uniform usamplerBuffer t_offers;     // Offers there
layout(std430, binding = kBufferNearest) buffer Nearest { uvec2 b_nearest[]; };  // [pixel] triangle + 1 and, in the low bits, effort, 0: none | m: how far
const int kCounterTexels = 2;

void main() {
  ivec2 size = textureSize(t_ray_direction, 0);
  int columns = tile_columns(size), index = int(gl_GlobalInvocationID.x), tile = index / (kTile * kTile), within = index % (kTile * kTile);
  ivec2 pixel = kTile * ivec2(tile % columns, tile / columns) + ivec2(within % kTile, within / kTile);
  if (any(greaterThanEqual(pixel, size))) return;
  vec4 direction = texelFetch(t_ray_direction, pixel, 0);
  uint node = direction.w > 0.0 ? texelFetch(t_lists, kCounterTexels + tile).x : 0u;
  if (node == 0u) return;
  vec3 origin = texelFetch(t_ray_origin, pixel, 0).xyz;
  int at = pixel.y * size.x + pixel.x, reflector = int(direction.w) - 1;
  uvec2 held = b_nearest[at];
  float held_m = held.x == 0u ? 1e30 : uintBitsToFloat(held.y);
  while (node != 0u) {
    uvec2 entry = texelFetch(t_lists, kCounterTexels + int(node)).xy;
    int offer = 5 * int(entry.x);
    uvec4 a = texelFetch(t_offers, offer), b = texelFetch(t_offers, offer + 1), c = texelFetch(t_offers, offer + 2);
    float along_m = distance_to(origin, direction.xyz, SceneTriangle(uintBitsToFloat(a.xyz), uintBitsToFloat(b.xyz), uintBitsToFloat(c.xyz)));
    bool nearer = along_m >= 0.0 && int(c.w) == reflector && (along_m < held_m || (along_m == held_m && a.w < held.x));
    held = nearer ? uvec2(a.w, floatBitsToUint(along_m)) : held;
    held_m = nearer ? along_m : held_m;
    node = entry.y;
  }
  b_nearest[at] = held;
}
