// The life of a bake, with a kind that counts: key, run, cancel, progress, parts, failure, load, save, resume.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <semaphore>
#include <stdexcept>
#include <thread>

#include "render/bake/bake_runner.h"
#include "render/bake/kept_bakes.h"
#include "tests/scenes/temporary_folder.h"

namespace maquette {
namespace {

/// Numbers from 0 to `count`, one a step. A step waits for `gate` where there is one, and for the cancellation after
/// `stop_after` of them.
struct CountJob {
  int count = 3;
  std::string path = {};
  bool must_work = true;
  int fail_at = -1;
  int stop_after = 1000;
  std::shared_ptr<std::counting_semaphore<>> gate = {};
};
using Numbers = std::vector<int>;

class CountKind : public FileBakeKind<CountJob, Numbers> {
 public:
  explicit CountKind(bool shows_parts = false) : shows_parts_(shows_parts) {}
  Baked<Numbers> run(const CountJob& job, const Baked<Numbers>& kept, const BakeTask<Numbers>& task) override {
    Numbers numbers = kept.value ? *kept.value : Numbers();
    const std::size_t before = numbers.size();
    while (static_cast<int>(numbers.size()) < job.count) {
      const int next = static_cast<int>(numbers.size());
      if (job.gate) job.gate->acquire();
      while (next >= job.stop_after && !task.cancel) std::this_thread::yield();
      if (task.cancel) break;
      if (next == job.fail_at) throw std::runtime_error("no number " + std::to_string(next));
      numbers.push_back(next);
      ++steps;
      if (task.progress) task.progress(static_cast<double>(numbers.size()) / job.count);
      task.publish(numbers);
    }
    const bool complete = static_cast<int>(numbers.size()) == job.count;
    const bool saved = numbers.size() == before;
    if (!complete && saved) return {};
    return {std::make_shared<const Numbers>(std::move(numbers)), complete, saved};
  }
  bool shows_parts() const override { return shows_parts_; }
  std::atomic<int> steps{0};

 protected:
  BakePlace place(const CountJob& job) const override { return {job.path, job.must_work}; }
  Numbers read(const std::string& path) const override {
    std::ifstream file(path);
    Numbers numbers;
    for (std::string word; file >> word;) {
      if (word == "damaged") throw Error(path, "it is damaged");
      if (word != "whole" && word != "part") numbers.push_back(std::stoi(word));
    }
    return numbers;
  }
  void write(const std::string& path, const CountJob&, const Numbers& numbers, bool complete) const override {
    std::string text = complete ? "whole" : "part";
    for (const int n : numbers) text += " " + std::to_string(n);
    write_file_atomically(path, std::as_bytes(std::span(text)));
  }

 private:
  bool shows_parts_;
};

class CountBake final : public KeyedBake<std::string, CountJob, Numbers> {
 public:
  explicit CountBake(std::shared_ptr<CountKind> kind = std::make_shared<CountKind>()) : KeyedBake(std::move(kind)) {}
  const char* name() const override { return "numbers"; }
  bool update(const std::string& key, const CountJob& job) {
    if (require(key, [&] { return job; })) return false;  // a short run might be done already
    const auto numbers = take();
    if (numbers) shown = *numbers;
    return numbers != nullptr;
  }
  bool ready() const override { return !shown.empty(); }
  std::size_t bytes() const override { return shown.size() * sizeof(int); }
  Numbers shown;
};

TEST(Bake, RunsOnceForAKeyAndIsShownOnce) {
  const auto kind = std::make_shared<CountKind>();
  CountBake bake(kind);
  EXPECT_EQ(bake.state(), BakeState::absent);
  EXPECT_FALSE(bake.busy());
  bake.wait();
  const auto gate = std::make_shared<std::counting_semaphore<>>(0);
  EXPECT_FALSE(bake.update("a", {.count = 3, .gate = gate}));
  EXPECT_TRUE(bake.busy());
  EXPECT_EQ(bake.state(), BakeState::running);
  gate->release(3);
  bake.wait();
  EXPECT_FALSE(bake.busy());
  EXPECT_DOUBLE_EQ(bake.progress(), 1.0);
  EXPECT_TRUE(bake.update("a", {}));
  EXPECT_EQ(bake.state(), BakeState::ready);
  EXPECT_EQ(bake.shown, (Numbers{0, 1, 2}));
  EXPECT_EQ(bake.bytes(), 3 * sizeof(int));
  EXPECT_FALSE(bake.update("a", {.count = 5}));
  bake.wait();
  EXPECT_FALSE(bake.update("a", {.count = 5}));
  EXPECT_EQ(kind->steps, 3);
}

TEST(Bake, AnotherKeyCancelsAndTheOldOneStaysUntilThen) {
  CountBake bake;
  bake.update("a", {.count = 2});
  bake.wait();
  EXPECT_TRUE(bake.update("a", {}));
  bake.update("b", {.count = 1000000, .stop_after = 4});  // never done by itself
  EXPECT_EQ(bake.shown.size(), 2u);
  EXPECT_EQ(bake.state(), BakeState::ready);
  EXPECT_TRUE(bake.busy());
  bake.update("c", {.count = 3});
  bake.wait();
  EXPECT_TRUE(bake.update("c", {}));
  EXPECT_EQ(bake.shown.size(), 3u);
}

TEST(Bake, CancelledItIsNeverShownAndBeginsAnew) {
  CountBake bake;
  bake.update("a", {.count = 9, .stop_after = 2});
  bake.cancel();
  bake.wait();
  EXPECT_FALSE(bake.busy());
  EXPECT_EQ(bake.state(), BakeState::absent);
  EXPECT_FALSE(bake.update("a", {.count = 1}));  // the key is forgotten: this starts a run
  bake.wait();
  EXPECT_TRUE(bake.update("a", {}));
  EXPECT_EQ(bake.shown.size(), 1u);
}

TEST(Bake, AFailureIsThrownOnceAndAnotherKeyMendsIt) {
  CountBake bake;
  bake.update("a", {.count = 4, .fail_at = 2});
  bake.wait();
  EXPECT_THROW(bake.update("a", {}), std::runtime_error);
  EXPECT_EQ(bake.state(), BakeState::failed);
  EXPECT_FALSE(bake.update("a", {}));
  EXPECT_EQ(bake.state(), BakeState::failed);
  EXPECT_FALSE(bake.busy());
  bake.update("b", {});
  bake.wait();
  EXPECT_TRUE(bake.update("b", {}));
  EXPECT_EQ(bake.state(), BakeState::ready);
}

TEST(Bake, PartsComeInOrderAndSayThatTheyAreParts) {
  CountBake bake(std::make_shared<CountKind>(true));
  const auto gate = std::make_shared<std::counting_semaphore<>>(0);
  const CountJob job{.count = 5, .gate = gate};
  std::vector<Numbers> seen;
  bake.update("a", job);
  for (int step = 1; step <= 4; ++step) {
    gate->release();
    while (!bake.update("a", job)) std::this_thread::yield();
    EXPECT_EQ(static_cast<int>(bake.shown.size()), step);
    EXPECT_EQ(bake.state(), BakeState::partial);
    EXPECT_TRUE(bake.busy());
  }
  gate->release();
  bake.wait();
  EXPECT_TRUE(bake.update("a", job));
  EXPECT_EQ(bake.shown, (Numbers{0, 1, 2, 3, 4}));
  EXPECT_EQ(bake.state(), BakeState::ready);
}

TEST(Bake, PartsOfAKindThatShowsNoneStayUnseen) {
  CountBake bake;
  const auto gate = std::make_shared<std::counting_semaphore<>>(0);
  bake.update("a", {.count = 3, .gate = gate});
  gate->release(2);
  while (bake.progress() < 0.6) std::this_thread::yield();
  EXPECT_FALSE(bake.update("a", {}));
  gate->release();
  bake.wait();
  EXPECT_TRUE(bake.update("a", {}));
}

TEST(Bake, TwoRunAtOnce) {
  const auto ours = std::make_shared<std::counting_semaphore<>>(0),
             theirs = std::make_shared<std::counting_semaphore<>>(0);
  CountBake first, second;
  first.update("a", {.count = 1, .gate = ours});
  second.update("a", {.count = 2, .gate = theirs});
  EXPECT_TRUE(first.busy());
  EXPECT_TRUE(second.busy());
  theirs->release(2);
  second.wait();
  EXPECT_TRUE(first.busy());
  ours->release();
  first.wait();
  EXPECT_TRUE(first.update("a", {}));
  EXPECT_TRUE(second.update("a", {}));
  EXPECT_EQ(first.shown.size() + second.shown.size(), 3u);
}

TEST(Bake, MayGoAwayAtAnyTime) {
  for (int i = 0; i < 20; ++i) {
    CountBake bake;
    bake.update("a", {.count = 9, .stop_after = i % 3});
  }
}

using BakeFileTest = test::TemporaryFolder;

Baked<Numbers> make(CountKind* kind, const CountJob& job) {
  const std::atomic<bool> run{false};
  return make_bake(*kind, job, {run});
}

TEST_F(BakeFileTest, IsSavedAndNotMadeAgain) {
  CountKind kind;
  const CountJob job{.count = 3, .path = path("deeper/numbers")};
  EXPECT_TRUE(make(&kind, job).complete);
  EXPECT_EQ(read(job.path), "whole 0 1 2");
  const auto written = std::filesystem::last_write_time(job.path);
  const Baked<Numbers> again = make(&kind, job);
  EXPECT_EQ(*again.value, (Numbers{0, 1, 2}));
  EXPECT_EQ(kind.steps, 3);
  EXPECT_EQ(std::filesystem::last_write_time(job.path), written);
}

TEST_F(BakeFileTest, AnInterruptedRunResumes) {
  CountKind kind;
  const CountJob job{.count = 6, .path = path("numbers")};
  std::atomic<bool> cancel{false};
  const Baked<Numbers> stopped = make_bake(kind, job, {cancel, [&](double p) { cancel = p >= 0.5; }});
  EXPECT_EQ(stopped.value, nullptr);
  EXPECT_EQ(read(job.path), "part 0 1 2");
  EXPECT_EQ(*make(&kind, job).value, (Numbers{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(kind.steps, 6);
  EXPECT_EQ(read(job.path), "whole 0 1 2 3 4 5");
}

TEST_F(BakeFileTest, CancelledBeforeAnythingIsDoneItLeavesNoFile) {
  CountKind kind;
  const std::atomic<bool> cancel{true};
  EXPECT_EQ(make_bake(kind, {.path = path("numbers")}, {cancel}).value, nullptr);
  EXPECT_EQ(file_count(), 0u);
}

TEST_F(BakeFileTest, ADamagedFileIsMadeAnewAndOneThatCannotBeWrittenIsAnErrorWhereItWasNamed) {
  CountKind kind;
  CountJob job{.count = 2, .path = path("numbers")};
  std::ofstream(job.path) << "damaged";
  EXPECT_EQ(make(&kind, job).value->size(), 2u);
  EXPECT_EQ(read(job.path), "whole 0 1");
  // A file for a folder: nothing can be written there.
  job.path = path("numbers/inside");
  job.must_work = false;
  EXPECT_EQ(make(&kind, job).value->size(), 2u);
  job.must_work = true;
  EXPECT_THROW(make(&kind, job), Error);
}

/// Published parts are saved from time to time; here at every one.
TEST_F(BakeFileTest, WhatIsPublishedIsSavedBeforeTheEnd) {
  struct Eager : CountKind {
    std::chrono::seconds save_interval() const override { return std::chrono::seconds(0); }
  } kind;
  const CountJob job{.count = 3, .path = path("numbers"), .fail_at = 2};
  EXPECT_THROW(make(&kind, job), std::runtime_error);
  EXPECT_EQ(read(job.path), "part 0 1");
}

}  // namespace
}  // namespace maquette
