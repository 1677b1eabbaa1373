// Triangles of a mirror, as render/triangle/reflections.cpp writes them.
layout(binding = 54) uniform samplerBuffer t_facets;
const int kFacetTexels = 22;
