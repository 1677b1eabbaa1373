#pragma once

#include <string>

namespace maquette {

/// Value of GLIBC_TUNABLES that makes malloc request large pages (2 MiB); `now`: its current value (null: not set).
/// Empty when the user has set glibc.malloc.hugetlb.
std::string tunables_with_large_pages(const char* now);

/// Restarts the program once with memory in large pages: the C library reads the setting only at the start of a
/// process. Page faults on new memory then number hundreds instead of hundreds of thousands. Call it first in main; if
/// a restart is not possible the program continues.
void restart_in_large_pages(char** argv);

}  // namespace maquette
