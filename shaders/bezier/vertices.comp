// Projects the vertices of the clusters that may be seen in one patch.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "bezier/project.glsl"
layout(binding = kUnitVertices) uniform samplerBuffer t_vertices;
// 2 a vertex: px on screen, x | status, in front, steps, distance to the vertex; derivative of the screen position by the vertex, px/m: six halves
layout(std430, binding = kBufferProjections) writeonly buffer Projections { uvec4 b_projected[]; };
layout(std430, binding = kBufferBezierCounters) buffer Counters { uint b_counters[16]; };
layout(std430, binding = kBufferPatchVertices) readonly buffer Vertices { uvec2 b_vertices[]; };  // vertex, start
// 5 a cluster: its middle's parameters, certified | derivatives of both by the position of a point | middle, radius, m | half extent, m
layout(std430, binding = kBufferPatchStarts) readonly buffer Starts { vec4 b_starts[]; };
uniform int u_count;

const float kSteepest = 6e4;  // px/m: a half holds no more

void main() {
  int i = int(gl_GlobalInvocationID.x);
  if (i >= u_count) return;
  uvec2 of = b_vertices[i];
  int vertex = int(of.x);
  vec3 world = texelFetch(t_vertices, 4 * vertex).xyz;
  vec4 middle = b_starts[5u * of.y], center = b_starts[5u * of.y + 3u];
  vec3 from_middle = world - center.xyz;
  BezierStart start = no_start(u_side);
  start.x = middle.xy + vec2(dot(b_starts[5u * of.y + 1u].xyz, from_middle), dot(b_starts[5u * of.y + 2u].xyz, from_middle));
  start.x = clamp(start.x, middle.xy - 0.75, middle.xy + 0.75);
  start.shortest = clamp(start.x, vec2(-1.0), vec2(1.0));
  start.certified = middle.z > 0.0;
  Projected v = project_from(world, start);
  int steps = v.steps;
  if (v.status == kReflectionLost) {
    v = project_from(world, find_start(world - u_patches[u_patch].origin.xyz));
    steps += v.steps;
  }
  mat2x3 d = screen_derivative(world - u_patches[u_patch].origin.xyz, v.x);
  d = mat2x3(clamp(d[0], -kSteepest, kSteepest), clamp(d[1], -kSteepest, kSteepest));
  b_projected[2 * vertex] = floatBitsToUint(vec4(v.at, v.x));
  b_projected[2 * vertex + 1] = uvec4(uint(v.status) | (v.in_front ? 4u : 0u) | uint(min(v.steps, 127)) << 3u | packHalf2x16(vec2(0.0, min(0.999 * v.along_m, 6e4))), packHalf2x16(d[0].xy),
                                      packHalf2x16(vec2(d[0].z, d[1].x)), packHalf2x16(d[1].yz));
  atomicAdd(b_counters[3], uint(steps));
  atomicAdd(b_counters[4], 1u);
  if (v.status == kReflectionLost) atomicAdd(b_counters[5], 1u);
  if (!v.certified) atomicAdd(b_counters[6], 1u);
}
