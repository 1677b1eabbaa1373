#pragma once

/// Of a function whose loops run in lanes: compiled for wider registers as well, the same operations in the same order,
/// so that no result changes.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define MAQUETTE_WIDE __attribute__((target_clones("avx2", "default")))
#else
#define MAQUETTE_WIDE
#endif
