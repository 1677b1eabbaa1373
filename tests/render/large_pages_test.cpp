#include "render/large_pages.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>

namespace maquette {
namespace {

TEST(LargePages, KeepsWhatIsInThem) {
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{1} << 18, std::size_t{5} << 20}) {
    std::vector<std::uint32_t> values(size);
    std::iota(values.begin(), values.end(), 7u);
    prefer_large_pages(values);
    prefer_large_pages(values.data() + size / 3, (size - size / 3) * sizeof(std::uint32_t) / 2);
    for (std::size_t i = 0; i < size; ++i) ASSERT_EQ(values[i], 7u + i);
  }
}

TEST(LargePages, NewOnesAreEmptyAndHoldWhatIsWritten) {
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{1} << 18, std::size_t{5} << 20}) {
    std::vector<std::uint32_t> values;
    resize_in_large_pages(&values, size);
    ASSERT_EQ(values.size(), size);
    for (std::size_t i = 0; i < size; ++i) ASSERT_EQ(values[i], 0u);
    std::iota(values.begin(), values.end(), 7u);
    for (std::size_t i = 0; i < size; ++i) ASSERT_EQ(values[i], 7u + i);
  }
}

}  // namespace
}  // namespace maquette
