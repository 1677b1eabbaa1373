#include "render/large_pages.h"

#include <sys/mman.h>

#include <cstdint>

namespace maquette {

namespace {

constexpr std::uintptr_t kPage = std::uintptr_t{2} << 20;
#ifdef MADV_COLLAPSE
constexpr int kCollapse = MADV_COLLAPSE;
#else
constexpr int kCollapse = 25;  // Linux 6.1; older ones refuse it
#endif

/// Whether it was heeded; of whole pages only.
bool advise(const void* data, std::size_t bytes, int advice) {
  const auto begin = reinterpret_cast<std::uintptr_t>(data);
  const std::uintptr_t first = (begin + kPage - 1) / kPage * kPage, last = (begin + bytes) / kPage * kPage;
  return first < last && madvise(reinterpret_cast<void*>(first), last - first, advice) == 0;
}

}  // namespace

void prefer_large_pages(const void* data, std::size_t bytes) {
  // The first call allows large pages, the second makes them of what is there already.
  if (advise(data, bytes, MADV_HUGEPAGE)) (void)advise(data, bytes, kCollapse);
}

void allow_large_pages(const void* data, std::size_t bytes) { (void)advise(data, bytes, MADV_HUGEPAGE); }

}  // namespace maquette
