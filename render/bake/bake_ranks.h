#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <functional>
#include <string>

namespace maquette {

/// Processes that share a bake: each makes the blocks whose number is its own modulo `count`, and waits for the files
/// of the others.
struct BakeRanks {
  int rank = 0, count = 1;
  double patience_s = 60.0;  ///< see RankPatience
  /// What is waited for and taken over, for the user; null: nobody asks.
  std::function<void(const std::string&)> say = {};
  bool has(std::size_t block) const {
    return count == 1 || static_cast<int>(block % static_cast<std::size_t>(count)) == rank;
  }
};
/// How long a process waits for files of others while none comes, before it makes what is missing itself: a process
/// that was lost holds up nobody, and what two of them make is the same. Ten times its own slowest block, at least
/// BakeRanks::patience_s.
class RankPatience {
 public:
  using Clock = std::chrono::steady_clock;
  explicit RankPatience(const BakeRanks& ranks) : patience_s_(ranks.patience_s), say_(ranks.say) {}
  void made_block(Clock::time_point begin) {
    patience_s_ = std::max(patience_s_, 10.0 * std::chrono::duration<double>(Clock::now() - begin).count());
  }
  /// Waits from now on, for so many.
  void begin(std::size_t missing) {
    block_came();
    if (say_ && missing > 0) say_("waiting for " + std::to_string(missing) + " blocks of other processes");
  }
  void block_came() { since_ = Clock::now(); }
  bool is_over() {
    const bool over = std::chrono::duration<double>(Clock::now() - since_).count() >= patience_s_;
    if (over && say_ && !said_) say_("no other process makes blocks any more: the missing ones are made here");
    said_ |= over;
    return over;
  }

 private:
  double patience_s_;
  std::function<void(const std::string&)> say_;
  bool said_ = false;
  Clock::time_point since_ = Clock::now();
};
/// Of `mpirun`: its variables OMPI_COMM_WORLD_RANK and _SIZE, or PMI_RANK and PMI_SIZE; else one process.
BakeRanks ranks_from_environment();

}  // namespace maquette
