#include "render/raytraced/ray_device.h"

#include "scenes/parallel.h"

namespace maquette {

RTCDevice new_ray_device() {
  parallel_for(0, 2, [](int) {});
  return rtcNewDevice(nullptr);
}

}  // namespace maquette
