#include "render/large_pages.h"

#include <sys/mman.h>

#include <cstdint>

namespace maquette {

void prefer_large_pages(const void* data, std::size_t bytes) {
  constexpr std::uintptr_t kPage = std::uintptr_t{2} << 20;
#ifdef MADV_COLLAPSE
  constexpr int kCollapse = MADV_COLLAPSE;
#else
  constexpr int kCollapse = 25;  // Linux 6.1; older ones refuse it
#endif
  const auto begin = reinterpret_cast<std::uintptr_t>(data);
  const std::uintptr_t first = (begin + kPage - 1) / kPage * kPage, last = (begin + bytes) / kPage * kPage;
  if (first >= last) return;
  auto* pages = reinterpret_cast<void*>(first);
  // The first call allows large pages, the second makes them of what is there already.
  if (madvise(pages, last - first, MADV_HUGEPAGE) == 0) (void)madvise(pages, last - first, kCollapse);
}

}  // namespace maquette
