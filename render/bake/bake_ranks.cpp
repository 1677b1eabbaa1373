#include "render/bake/bake_ranks.h"

#include <cstdlib>
#include <utility>

namespace maquette {

namespace {

int number_of(const char* name) {
  const char* value = std::getenv(name);
  return value ? static_cast<int>(std::strtol(value, nullptr, 10)) : -1;
}

}  // namespace

BakeRanks ranks_from_environment() {
  for (const auto& [rank, size] :
       {std::pair("OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"), std::pair("PMI_RANK", "PMI_SIZE")})
    if (number_of(rank) >= 0 && number_of(size) > number_of(rank)) return {number_of(rank), number_of(size)};
  return {};
}

}  // namespace maquette
