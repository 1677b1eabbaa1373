#pragma once

#include "scenes/scene.h"

namespace maquette::builtin {

/// Instrument cluster, 640 x 240: two round gauges and a route between them.
TextureImage make_cluster_image();
/// Centre screen, 512 x 320: a street map with a side bar.
TextureImage make_center_image();
/// Tileable asphalt, 256 x 256.
TextureImage make_asphalt_image();

}  // namespace maquette::builtin
