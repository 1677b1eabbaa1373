#pragma once

#include <embree3/rtcore.h>

namespace maquette {

/// A device of the ray tracer, null where it does not start. TBB keeps the rounding of floats that a thread has when it
/// first uses it, and the ray tracer builds its hierarchies with denormals flushed: had a thread's first use been that,
/// all its later loops would flush them too, and the same scene would have other bits (and another hash) than else. So
/// the calling thread uses TBB before it builds anything.
RTCDevice new_ray_device();

}  // namespace maquette
