#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "render/bake/background_worker.h"
#include "render/bake/bake.h"
#include "render/bake/bake_kind.h"

namespace maquette {

/// Makes one kind of bake on a thread of its own.
template <typename Input, typename Value>
class BakeWorker : public BackgroundWorker<Input, Baked<Value>> {
 public:
  using Kind = BakeKind<Input, Value>;
  using Base = BackgroundWorker<Input, Baked<Value>>;
  explicit BakeWorker(std::shared_ptr<Kind> kind, typename Base::Spare spare = {})
      : Base(
            [kind = std::move(kind)](const Input& input, const BackgroundTask<Baked<Value>>& task) {
              BakeTask<Value> bake{task.cancel, task.progress};
              if (kind->shows_parts())
                bake.publish = [&](const Value& part) { task.publish({std::make_shared<const Value>(part)}); };
              Baked<Value> baked = make_bake(*kind, input, bake);
              return baked.value ? std::optional(std::move(baked)) : std::nullopt;
            },
            std::move(spare)) {}
};

/// A bake that a worker makes, whose thread begins with the first run. Owners derive from it, decide when to run it and
/// keep what comes.
template <typename Input, typename Value>
class BakeRunner : public Bake {
 public:
  using Worker = BakeWorker<Input, Value>;

  BakeState state() const override {
    if (failed_) return BakeState::failed;
    if (ready()) return partial_ ? BakeState::partial : BakeState::ready;
    return busy() ? BakeState::running : BakeState::absent;
  }
  bool busy() const override { return worker_ && worker_->busy(); }
  double progress() const override { return worker_ ? worker_->progress() : 0.0; }
  void wait() override {
    if (worker_) worker_->wait();
  }
  void cancel() override {
    if (worker_) worker_->cancel();
    failed_ = false;
  }

 protected:
  explicit BakeRunner(std::shared_ptr<BakeKind<Input, Value>> kind, typename Worker::Spare spare = {})
      : kind_(std::move(kind)), spare_(std::move(spare)) {}

  const BakeKind<Input, Value>& kind() const { return *kind_; }

  /// Cancels the run in work, unless it is spared, and starts this one. Does not wait.
  void submit(Input input) {
    if (!worker_) worker_ = std::make_unique<Worker>(kind_, spare_);
    failed_ = false;
    worker_->submit(std::move(input));
  }
  /// What the newest run has made, whole or a part, once. Rethrows what made it fail, once.
  std::shared_ptr<const Value> take() try {
    std::optional<Baked<Value>> baked = worker_ ? worker_->take() : std::nullopt;
    if (!baked) return nullptr;
    partial_ = !baked->complete;
    return std::move(baked->value);
  } catch (...) {
    failed_ = true;
    throw;
  }

 private:
  std::shared_ptr<BakeKind<Input, Value>> kind_;
  typename Worker::Spare spare_;
  bool failed_ = false, partial_ = false;
  std::unique_ptr<Worker> worker_;
};

/// A bake that runs whenever the key of all that it depends on has changed.
template <typename Key, typename Input, typename Value>
class KeyedBake : public BakeRunner<Input, Value> {
 public:
  void cancel() override {
    BakeRunner<Input, Value>::cancel();
    key_.reset();
  }

 protected:
  using BakeRunner<Input, Value>::BakeRunner;
  /// Starts a run when `key` is not that of the last one, and says so. `make_input` is called only then.
  template <typename MakeInput>
  bool require(Key key, const MakeInput& make_input) {
    if (key_ && *key_ == key) return false;
    this->submit(make_input());
    key_ = std::move(key);
    return true;
  }

 private:
  std::optional<Key> key_;  ///< of the last run
};

}  // namespace maquette
