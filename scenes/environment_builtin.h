#pragma once

#include "scenes/environment.h"

namespace maquette {

/// Clear sky with the sun 40 degrees up, above a light ground; 1024 x 512, cd/m2 (sun disc included, about 1e9 cd/m2).
/// Hash and warnings are left empty.
Environment make_clear_sky();
/// A car studio: strip lights overhead, soft boxes, a light floor that fades into a dark surround; 1024 x 512, cd/m2.
Environment make_studio();

}  // namespace maquette
