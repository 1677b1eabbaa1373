#pragma once

#include <chrono>
#include <thread>

namespace maquette::test {

/// Asks until it is so; false after ten minutes, which only a hang takes.
template <typename Condition>
bool comes_true(const Condition& condition) {
  constexpr std::chrono::minutes kLimit{10};
  constexpr std::chrono::milliseconds kPause{2};
  const auto end = std::chrono::steady_clock::now() + kLimit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(kPause);
  }
  return true;
}

}  // namespace maquette::test
