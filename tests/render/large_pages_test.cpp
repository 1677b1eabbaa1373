#include "render/raytraced/large_pages.h"

#include <gtest/gtest.h>

namespace maquette {
namespace {

TEST(LargePages, AreRequestedOnceAndKeepTheUsersChoice) {
  EXPECT_EQ(tunables_with_large_pages(nullptr), "glibc.malloc.hugetlb=1");
  EXPECT_EQ(tunables_with_large_pages(""), "glibc.malloc.hugetlb=1");
  EXPECT_EQ(tunables_with_large_pages("glibc.malloc.tcache_count=0"),
            "glibc.malloc.tcache_count=0:glibc.malloc.hugetlb=1");
  for (const char* decided :
       {"glibc.malloc.hugetlb=1", "glibc.malloc.hugetlb=0", "glibc.malloc.check=1:glibc.malloc.hugetlb=2"})
    EXPECT_EQ(tunables_with_large_pages(decided), "") << decided;
}

}  // namespace
}  // namespace maquette
