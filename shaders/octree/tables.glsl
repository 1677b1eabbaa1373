// The octree of the scene (render/octree/octree_buffers) and its traversal.
#include "shared/bindings.glsl"
layout(binding = kUnitOctree) uniform usamplerBuffer t_octree;               // [node]
layout(binding = kUnitOctreePlanes) uniform usamplerBuffer t_octree_planes;  // [node above the last level]
uniform vec4 u_octree;     // corner (m), cells of the last level per metre
uniform int u_octree_depth;
uniform int u_octree_detail;  // number of the deepest levels, which only cells with much detail have

uint octree_word(int node) { return texelFetch(t_octree, node).x; }
uint octree_plane_word(int node) { return texelFetch(t_octree_planes, node).x; }
#include "shared/octree.glsl"

OctreeFrame octree_frame() { return OctreeFrame(u_octree.xyz, u_octree.w, u_octree_depth, u_octree_detail); }
