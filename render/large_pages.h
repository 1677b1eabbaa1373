#pragma once

#include <string>

namespace maquette {

/// Value of GLIBC_TUNABLES by which malloc asks the system for large pages (2 MiB), `now` being what it is (null: not
/// set). Empty where the user has decided already (any glibc.malloc.hugetlb).
std::string tunables_with_large_pages(const char* now);

/// Begins the program anew, once, with memory in large pages: the C library reads that at the start of a process only.
/// What is touched for the first time then comes in hundreds of pages instead of a hundred thousand. Call it before
/// anything else; where it cannot be done the program just goes on.
void restart_in_large_pages(char** argv);

}  // namespace maquette
