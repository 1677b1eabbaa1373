#pragma once

#include <cstddef>
#include <vector>

namespace maquette {

/// Asks the system to keep memory that is filled and read at random in large pages (2 MiB), whose addresses it finds
/// sooner. A hint: where the system has none, or memory has no room for them, nothing happens.
void prefer_large_pages(const void* data, std::size_t bytes);

template <typename T>
void prefer_large_pages(const std::vector<T>& values) {
  prefer_large_pages(values.data(), values.size() * sizeof(T));
}

}  // namespace maquette
