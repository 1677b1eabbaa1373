#pragma once

#include <cstddef>

namespace maquette {

/// Processes that share a bake: each makes the blocks whose number is its own modulo `count`, and waits for the files
/// of the others.
struct BakeRanks {
  int rank = 0, count = 1;
  bool has(std::size_t block) const {
    return count == 1 || static_cast<int>(block % static_cast<std::size_t>(count)) == rank;
  }
};
/// Of `mpirun`: its variables OMPI_COMM_WORLD_RANK and _SIZE, or PMI_RANK and PMI_SIZE; else one process.
BakeRanks ranks_from_environment();

}  // namespace maquette
