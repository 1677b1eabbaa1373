// Tests of known compiler faults; CMakeLists.txt disables the optimisations that cause them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <glm/glm.hpp>
#include <random>
#include <vector>

namespace maquette {

struct LeftByFloat {
  double x, y;
};
/// Rounding errors of two doubles in float. Not inlined and with external linkage, so that the compiler cannot evaluate
/// it beforehand.
[[gnu::noinline]] LeftByFloat left_by_float(const LeftByFloat& v) {
  const float x = static_cast<float>(v.x), y = static_cast<float>(v.y);
  return {v.x - static_cast<double>(x), v.y - static_cast<double>(y)};
}

namespace {

/// GCC 12.2 from -O2 on, vectoriser of neighbouring operations.
TEST(Compiler, RoundsToFloat) {
  // 0.1 and 0.2 lie this far from the nearest floats.
  const LeftByFloat left = left_by_float({0.1, 0.2});
  EXPECT_NEAR(left.x, -1.4901161e-9, 1e-15);
  EXPECT_NEAR(left.y, -2.9802322e-9, 1e-15);
}

struct Three {
  float a, b, c;
};
Three three(std::size_t i) { return {static_cast<float>(i), static_cast<float>(i), static_cast<float>(i)}; }

/// Not inlined, so that the caller has to store its values to memory.
[[gnu::noinline]] void repeat_first(Three* values, std::size_t count) {
  for (std::size_t i = 1; i < count; ++i) values[i] = values[i - 1];
}
[[gnu::noinline]] void drop_first(Three* values, std::size_t count) {
  for (std::size_t i = 0; i + 1 < count; ++i) values[i] = values[i + 1];
}

/// GCC 12.2 at -O2, modref: treats stores before the call as dead.
TEST(Compiler, KeepsWhatACalleeReads) {
  constexpr std::size_t kCount = 4;
  const volatile std::size_t count = kCount;
  Three values[kCount];
  for (std::size_t i = 0; i < kCount; ++i) values[i] = three(i);
  repeat_first(values, count);
  for (std::size_t i = 1; i < kCount; ++i) EXPECT_EQ(values[i].b, 0.0f) << i;
  for (std::size_t i = 0; i < kCount; ++i) values[i] = three(i);
  drop_first(values, count);
  for (std::size_t i = 0; i + 1 < kCount; ++i) EXPECT_EQ(values[i].b, static_cast<float>(i + 1)) << i;
}

/// Algorithms that move elements through temporary memory or over each other, against indices that are moved in the
/// same way. GCC 12.2 at -O3, loop vectoriser, loses elements of stable_partition in nine of ten rounds.
template <typename Vector>
class CompilerMoves : public testing::Test {
 protected:
  using Component = typename Vector::value_type;
  /// All components differ from each other and from those of every other element.
  static Vector element(std::size_t index) {
    Vector v;
    for (int c = 0; c < Vector::length(); ++c) v[c] = static_cast<Component>(4 * index + static_cast<std::size_t>(c));
    return v;
  }
  static std::size_t index_of(const Vector& v) { return static_cast<std::size_t>(v.x) / 4; }

  /// Runs `move(all, middle, rank)` on the elements and on their indices; `middle`: a position in the sequence,
  /// `rank(v)`: 0 to 7.
  template <typename Move>
  void compare(const Move& move) {
    for (int round = 0; round < 2000; ++round) {
      std::vector<std::size_t> indices(1 + random_() % 40), ranks(indices.size());
      std::vector<Vector> elements;
      for (std::size_t i = 0; i < indices.size(); ++i) {
        indices[i] = i;
        ranks[i] = random_() % 8;
        elements.push_back(element(i));
      }
      const auto middle = static_cast<std::ptrdiff_t>(random_() % (indices.size() + 1));
      move(indices, middle, [&](std::size_t i) { return ranks[i]; });
      move(elements, middle, [&](const Vector& v) { return ranks[index_of(v)]; });
      ASSERT_EQ(elements.size(), indices.size());
      for (std::size_t i = 0; i < indices.size(); ++i)
        ASSERT_EQ(elements[i], element(indices[i]))
            << "round " << round << ", element " << i << " of " << indices.size();
    }
  }
  std::mt19937 random_{5};
};

using Vectors = testing::Types<glm::uvec2, glm::ivec2, glm::vec2, glm::vec3, glm::uvec3, glm::vec4, glm::uvec4,
                               glm::dvec2, glm::dvec3>;
TYPED_TEST_SUITE(CompilerMoves, Vectors);

TYPED_TEST(CompilerMoves, Partition) {
  this->compare([](auto& all, std::ptrdiff_t, const auto& rank) {
    std::stable_partition(all.begin(), all.end(), [&](const auto& v) { return rank(v) % 2 == 0; });
  });
}
TYPED_TEST(CompilerMoves, Sort) {
  this->compare([](auto& all, std::ptrdiff_t, const auto& rank) {
    std::stable_sort(all.begin(), all.end(), [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  });
}
TYPED_TEST(CompilerMoves, Merge) {
  this->compare([](auto& all, std::ptrdiff_t middle, const auto& rank) {
    const auto before = [&](const auto& a, const auto& b) { return rank(a) < rank(b); };
    std::stable_sort(all.begin(), all.begin() + middle, before);
    std::stable_sort(all.begin() + middle, all.end(), before);
    std::inplace_merge(all.begin(), all.begin() + middle, all.end(), before);
  });
}
TYPED_TEST(CompilerMoves, Rotate) {
  this->compare([](auto& all, std::ptrdiff_t middle, const auto&) {
    std::rotate(all.begin(), all.begin() + middle, all.end());
    std::reverse(all.begin() + middle / 2, all.end());
  });
}
TYPED_TEST(CompilerMoves, InsertAndErase) {
  this->compare([](auto& all, std::ptrdiff_t middle, const auto& rank) {
    const auto first = all.front();
    all.insert(all.begin() + middle, 3, first);
    all.erase(all.begin() + middle / 2, all.begin() + middle / 2 + 3);
    std::erase_if(all, [&](const auto& v) { return rank(v) == 0; });
  });
}

}  // namespace
}  // namespace maquette
