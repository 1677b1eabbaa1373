#pragma once

namespace maquette {

/// Low-pass taps of the Daubechies wavelet with four coefficients, unit energy: (1 +- sqrt 3), (3 +- sqrt 3) over 4
/// sqrt 2. The high-pass is {h3, -h2, h1, -h0}. Source: Daubechies 1992, Table 6.1, N = 2.
inline constexpr float kDaubechies4[4] = {0.48296291314453414f, 0.83651630373780791f, 0.22414386804201339f,
                                          -0.12940952255126037f};

}  // namespace maquette
