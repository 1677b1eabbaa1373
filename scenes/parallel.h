#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <type_traits>

namespace maquette {

/// Part of the indices that a loop runs over.
template <std::integral Index>
class IndexRange {
 public:
  IndexRange(Index begin, Index end) : begin_(begin), end_(end) {}
  Index begin() const { return begin_; }
  Index end() const { return end_; }
  std::size_t size() const { return static_cast<std::size_t>(end_ - begin_); }

 private:
  Index begin_, end_;
};

namespace parallel {

/// What a loop calls for a part of its indices: one function for all loops, so that TBB is compiled once.
using RunPart = void (*)(const void* body, std::int64_t begin, std::int64_t end);
void run_parts(std::int64_t begin, std::int64_t end, std::int64_t grain, RunPart run, const void* body);

}  // namespace parallel

/// Calls body(range) for parts of [begin, end) on all cores, in any order and division; a part of at most `grain`
/// indices is not divided. Rethrows one of the exceptions that were thrown.
template <std::integral Index, typename Body>
void parallel_ranges(std::type_identity_t<Index> begin, std::type_identity_t<Index> end,
                     std::type_identity_t<Index> grain, const Body& body) {
  parallel::run_parts(
      static_cast<std::int64_t>(begin), static_cast<std::int64_t>(end), static_cast<std::int64_t>(grain),
      [](const void* b, std::int64_t first, std::int64_t last) {
        (*static_cast<const Body*>(b))(IndexRange<Index>(static_cast<Index>(first), static_cast<Index>(last)));
      },
      &body);
}

/// Calls body(i) for every i in [begin, end) on all cores, in any order. Rethrows one of the exceptions that were
/// thrown.
template <std::integral Index, typename Body>
void parallel_for(Index begin, Index end, const Body& body) {
  parallel_ranges<Index>(begin, end, 1, [&body](const IndexRange<Index>& range) {
    for (Index i = range.begin(); i < range.end(); ++i) body(i);
  });
}

/// Calls all of them, on several cores, and waits.
void parallel_invoke(const std::function<void()>& a, const std::function<void()>& b,
                     const std::function<void()>& c = [] {});

}  // namespace maquette
