#include "scenes/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <cstddef>

namespace maquette {

namespace parallel {

void run_parts(std::int64_t begin, std::int64_t end, std::int64_t grain, RunPart run, const void* body) {
  if (begin >= end) return;
  tbb::parallel_for(tbb::blocked_range<std::int64_t>(begin, end, static_cast<std::size_t>(grain)),
                    [=](const tbb::blocked_range<std::int64_t>& range) { run(body, range.begin(), range.end()); });
}

}  // namespace parallel

void parallel_invoke(const std::function<void()>& a, const std::function<void()>& b, const std::function<void()>& c) {
  tbb::parallel_invoke(a, b, c);
}

}  // namespace maquette
