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

/// Allows large pages before anything is there: memory that is touched for the first time comes in them, which is
/// sooner than many small ones, and than large ones made of them afterwards.
void allow_large_pages(const void* data, std::size_t bytes);

/// `values` must be empty.
template <typename T>
void resize_in_large_pages(std::vector<T>* values, std::size_t count) {
  values->reserve(count);
  allow_large_pages(values->data(), count * sizeof(T));
  values->resize(count);
}

}  // namespace maquette
