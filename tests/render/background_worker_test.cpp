#include "render/bake/background_worker.h"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <semaphore>
#include <stdexcept>
#include <string>

namespace maquette {
namespace {

using namespace std::chrono_literals;
using Gate = std::shared_ptr<std::counting_semaphore<>>;

Gate closed_gate() { return std::make_shared<std::counting_semaphore<>>(0); }

/// Publishes its letters one by one, each after its gate lets it; the whole word is never the result itself.
struct SpellJob {
  std::string word;
  Gate gate;
  std::string prefix = {};
};

std::optional<std::string> spell(const SpellJob& job, const BackgroundTask<std::string>& task) {
  std::string so_far = job.prefix;
  for (const char letter : job.word) {
    job.gate->acquire();
    if (task.cancel) {
      EXPECT_TRUE(task.stop.stop_requested());
      return std::nullopt;
    }
    if (letter == '!') throw std::runtime_error("no such letter");
    task.publish(so_far += letter);
  }
  return std::nullopt;
}

TEST(BackgroundWorker, PublishesTheNewestWithoutEndingTheJob) {
  BackgroundWorker<SpellJob, std::string> worker(spell);
  const Gate gate = closed_gate();
  EXPECT_FALSE(worker.take(10s));  // no work: it does not wait
  worker.submit({"abc", gate});
  for (const char* expected : {"a", "ab", "abc"}) {
    EXPECT_FALSE(worker.take());
    gate->release();
    EXPECT_EQ(worker.take(60s), expected);
  }
  worker.wait();
  EXPECT_FALSE(worker.take(60s));
  worker.submit({"xy", gate});
  gate->release(2);
  worker.wait();
  EXPECT_EQ(worker.take(), "xy");  // the newest stands for the others
}

TEST(BackgroundWorker, WhatACancelledJobPublishesIsNeverSeen) {
  BackgroundWorker<SpellJob, std::string> worker(spell);
  const Gate old_gate = closed_gate(), gate = closed_gate();
  worker.submit({"old", old_gate});
  old_gate->release();
  EXPECT_EQ(worker.take(60s), "o");
  worker.submit({"n", gate});
  old_gate->release();
  gate->release();
  EXPECT_EQ(worker.take(60s), "n");
  worker.submit({"old", old_gate});
  worker.cancel();
  old_gate->release(3);
  EXPECT_FALSE(worker.busy());
  EXPECT_FALSE(worker.take(60s));
}

TEST(BackgroundWorker, AFailureIsThrownOnceToWhomWaits) {
  BackgroundWorker<SpellJob, std::string> worker(spell);
  const Gate gate = closed_gate();
  gate->release(2);
  worker.submit({"!", gate});
  EXPECT_THROW(worker.take(60s), std::runtime_error);
  EXPECT_FALSE(worker.take());
  worker.submit({"a", gate});
  EXPECT_EQ(worker.take(60s), "a");
}

TEST(BackgroundWorker, AJobInheritsFromTheOneThatItReplacesBeforeItBegan) {
  BackgroundWorker<SpellJob, std::string> worker(spell);
  const Gate first_gate = closed_gate(), gate = closed_gate();
  const auto inherit = [](SpellJob* next, SpellJob&& waiting) { next->prefix = waiting.word; };
  worker.submit({"a", first_gate}, inherit);
  first_gate->release();
  EXPECT_EQ(worker.take(60s), "a");
  worker.wait();
  worker.submit({"busy", first_gate}, inherit);
  first_gate->release();
  EXPECT_EQ(worker.take(60s), "b");  // it has begun: nothing is inherited from it
  worker.submit({"in", gate}, inherit);
  worker.submit({"k", gate}, inherit);
  first_gate->release();
  gate->release();
  EXPECT_EQ(worker.take(60s), "ink");
}

}  // namespace
}  // namespace maquette
