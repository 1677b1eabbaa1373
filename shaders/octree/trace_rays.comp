// Traces a list of rays through the octree; used by tests and the benchmark.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "octree/tables.glsl"

struct RayRecord {
  vec3 origin;
  float t_min;
  vec3 direction;
  float t_max;
  float t_box, width, spread, unused;
};
struct HitRecord {
  float t;
  int node, level, steps;
};
layout(std430, binding = kBufferOctreeRays) readonly buffer Rays { RayRecord b_rays[]; };
layout(std430, binding = kBufferOctreeHits) writeonly buffer Hits { HitRecord b_hits[]; };

void main() {
  uint id = gl_GlobalInvocationID.x;
  if (id >= uint(b_rays.length())) return;
  RayRecord r = b_rays[id];
  OctreeHit hit = octree_trace(octree_frame(), OctreeRay(r.origin, r.direction, r.t_min, r.t_max, r.t_box, r.width, r.spread));
  b_hits[id] = HitRecord(hit.t, hit.node, hit.level, hit.steps);
}
