#include "render/raytraced/ray_device.h"

#include <tbb/parallel_for.h>

namespace maquette {

RTCDevice new_ray_device() {
  tbb::parallel_for(0, 2, [](int) {});
  return rtcNewDevice(nullptr);
}

}  // namespace maquette
