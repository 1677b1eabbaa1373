#pragma once

namespace maquette::test {

/// A sheet with texels below a faint sky with a sun of 0.27 degrees half angle: what is traced to arrive at a texel,
/// over what quadrature of the environment gives, less 1. Suns of `trial` 0, 1, 2, ...: anywhere above the sheet, on
/// edges between bins of the lumisphere, and at the rim, where a part of it is below the horizon, in turn.
double sun_irradiance_error(int trial);

}  // namespace maquette::test
