// Triangles of a mirror, as render/triangle/reflections.cpp writes them.
#include "shared/bindings.glsl"
layout(binding = kUnitFacets) uniform samplerBuffer t_facets;
const int kFacetTexels = 22;
