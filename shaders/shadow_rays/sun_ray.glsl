// The sun's ray of a point, on the device and on the processor (render/shadow_rays/sun_shadows.cpp).
#include "shared/hash.glsl"
/// Sine of the largest angle between two directions of a compact sun, with a margin.
const float kSunRadius = 0.1f;
const uint kSunSeed = 0x51ed270bu;
/// Entry of the sun's list, whose length is a power of two. `mask`: hash of the pixel.
MAQUETTE_FN uint sun_ray(uint mask, uint frame, uint length) { return (frame ^ hash(mask)) & (length - 1u); }
