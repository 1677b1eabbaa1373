// Luminance of linear Rec. 709 colour. Common subset of GLSL and C++ with GLM (scenes/luminance.h).
// Source: ITU-R BT.709, Sec. 3.
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

MAQUETTE_FN float luminance(vec3 c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }
