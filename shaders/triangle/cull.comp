// From the clusters that may be seen in a triangle of a mirror, keeps the scene triangles that are not outside a plane of its mirrored frustum.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "triangle/facets.glsl"
layout(binding = kUnitIndices) uniform usamplerBuffer t_indices;
layout(binding = kUnitVertices) uniform samplerBuffer t_vertices;
layout(binding = kUnitClusterPairs) uniform usamplerBuffer t_pairs;          // mirror triangle, cluster
layout(binding = kUnitTriangleClusters) uniform usamplerBuffer t_clusters;   // first triangle, count
layout(binding = kUnitClusterTriangles) uniform usamplerBuffer t_triangles;  // numbers in the scene
layout(std430, binding = kBufferKeptPairs) writeonly buffer Kept { uvec2 b_kept[]; };  // mirror triangle, triangle
layout(std430, binding = kBufferPairCounters) buffer Counters { uint b_kept_count, b_unused[3]; };
uniform int u_count;

const int kMostTriangles = 128;  // of a cluster

void main() {
  int i = int(gl_GlobalInvocationID.x), pair = i / kMostTriangles, t = i % kMostTriangles;
  if (pair >= u_count) return;
  uvec2 of_pair = texelFetch(t_pairs, pair).xy, cluster = texelFetch(t_clusters, int(of_pair.y)).xy;
  if (t >= int(cluster.y)) return;
  int at = kFacetTexels * int(of_pair.x), triangle = int(texelFetch(t_triangles, int(cluster.x) + t).x);
  vec3 base = texelFetch(t_facets, at + 14).xyz, widening = texelFetch(t_facets, at + 21).xyz;
  bvec3 beyond = bvec3(true);
  for (int k = 0; k < 3; ++k) {
    vec4 p = vec4(texelFetch(t_vertices, 4 * int(texelFetch(t_indices, 3 * triangle + k).x)).xyz, 1.0);
    vec3 side = vec3(dot(texelFetch(t_facets, at + 18), p), dot(texelFetch(t_facets, at + 19), p), dot(texelFetch(t_facets, at + 20), p));
    bvec3 outside = greaterThan(side, widening * length(p.xyz - base));
    beyond = bvec3(beyond.x && outside.x, beyond.y && outside.y, beyond.z && outside.z);
  }
  if (!any(beyond)) b_kept[atomicAdd(b_kept_count, 1u)] = uvec2(of_pair.x, uint(triangle));
}
