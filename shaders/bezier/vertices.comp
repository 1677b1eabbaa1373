// Projects the vertices of one item into one patch.
layout(local_size_x = 64) in;
#include "bezier/project.glsl"
layout(binding = 5) uniform samplerBuffer t_vertices;
layout(std430, binding = 2) writeonly buffer Projections { vec4 b_projected[]; };  // 2 a vertex: clip | x, height, status
layout(std430, binding = 3) buffer Counters { uint b_counters[16]; };
uniform int u_first_vertex;
uniform int u_vertex_count;

void main() {
  int i = int(gl_GlobalInvocationID.x);
  if (i >= u_vertex_count) return;
  int vertex = u_first_vertex + i;
  vec3 world = texelFetch(t_vertices, 4 * vertex).xyz;
  BezierStart start = find_start(world - u_reflectors[u_reflector].origin.xyz);
  Projected v = project_from(world, start);
  b_projected[2 * vertex] = v.clip;
  b_projected[2 * vertex + 1] = vec4(v.x, v.height, float(v.status));
  atomicAdd(b_counters[3], uint(v.steps));
  atomicAdd(b_counters[4], 1u);
  if (v.status == kReflectionLost) atomicAdd(b_counters[5], 1u);
  if (!v.certified) atomicAdd(b_counters[6], 1u);
}
