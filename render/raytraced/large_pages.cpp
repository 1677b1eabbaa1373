#include "render/raytraced/large_pages.h"

#include <unistd.h>

#include <cstdlib>

namespace maquette {

std::string tunables_with_large_pages(const char* now) {
  const std::string before = now ? now : "";
  if (before.find("glibc.malloc.hugetlb") != std::string::npos) return {};
  return before + (before.empty() ? "" : ":") + "glibc.malloc.hugetlb=1";
}

void restart_in_large_pages(char** argv) {
  const std::string tunables = tunables_with_large_pages(std::getenv("GLIBC_TUNABLES"));
  if (tunables.empty() || setenv("GLIBC_TUNABLES", tunables.c_str(), 1) != 0) return;
  execv("/proc/self/exe", argv);
}

}  // namespace maquette
