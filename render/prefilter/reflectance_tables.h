#pragma once

#include "scenes/image.h"

namespace maquette {

/// Reflectance of a surface per lobe under a constant sky: the energy half of the prefiltered modes, whose other half
/// is a lookup in a filtered sky. No OpenGL. Both tables take some 50 ms for size 64.

/// split_sum_table with two more channels. 2: albedo of the sheen lobe, rows are its roughness; 3: mean Schlick weight
/// (1 - wo.h)^5 over cosine-distributed light, the same in every row. [size rows][size: n.v = (x + 0.5) / size].
/// Source: KHR_materials_sheen (Charlie distribution, cheap visibility), as in shaders/shared/analytic.glsl.
Image reflectance_table(int size);
/// Of 64 x 64, made once: it depends on no environment.
const Image& reflectance_table();

/// Integral of exp(sharpness (cos(theta_h) - 1)) cos(theta_i) over the light's hemisphere; nv > 0.
double sg_albedo(double sharpness, double nv);

inline constexpr double kSgTableLog2Begin = -4.0;  ///< sharpness 2^-4 in the centre of row 0
inline constexpr double kSgTableLog2End = 27.0;    ///< in the centre of the last row

/// Natural logarithm of sg_albedo. [size rows: log2 of the sharpness, from kSgTableLog2Begin to kSgTableLog2End][size:
/// n.v = ((x + 0.5) / size)^2].
Image sg_albedo_table(int size);

}  // namespace maquette
