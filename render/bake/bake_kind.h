#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <utility>

namespace maquette {

/// What a run of a bake made or an earlier one left.
template <typename Value>
struct Baked {
  std::shared_ptr<const Value> value;  ///< null: nothing
  bool complete = false;               ///< nothing is left to be done
  bool saved = false;                  ///< it is already where it is kept
};

/// What a run of a bake is given besides its input.
template <typename Value>
struct BakeTask {
  const std::atomic<bool>& cancel;
  std::function<void(double)> progress = {};  ///< takes [0, 1]; may be empty
  /// Takes all that is made so far, to be saved from time to time and to be shown: one thread at a time, of any that
  /// the run uses. BakeKind::run always has it.
  std::function<void(const Value&)> publish = {};
};

/// How one kind of bake is made and kept. `load`, `run` and the last `save` are called on the bake's own thread; knows
/// no OpenGL. A new bake derives from it (or from CachedBakeKind or FileBakeKind), and its owner from KeyedBake.
template <typename Input, typename Value>
class BakeKind {
 public:
  virtual ~BakeKind() = default;
  /// Hash of all that the result depends on, by which it is kept (BakeKeys); empty: it is kept otherwise or not at all.
  /// May be called on any thread.
  virtual std::string key(const Input&) const { return {}; }
  /// What an earlier run left of `input`, in memory, the cache or a file: whole, or for `run` to go on from.
  virtual Baked<Value> load(const Input&) { return {}; }
  /// Makes what `kept` (perhaps nothing) lacks. When cancelled it gives what is worth keeping, not complete, or
  /// nothing.
  virtual Baked<Value> run(const Input&, const Baked<Value>& kept, const BakeTask<Value>&) = 0;
  /// Keeps it for a later `load`. Files are written beside their place and renamed.
  virtual void save(const Input&, const Value&, bool /*complete*/) {}
  /// Time between two saves of what was published.
  virtual std::chrono::seconds save_interval() const { return std::chrono::seconds(10); }
  /// Whether windows draw with a part. Each part that is published is then copied.
  virtual bool shows_parts() const { return false; }
};

/// The life of one bake: load; else run, save from time to time, save at the end or at the interruption. Nothing once
/// cancelled.
template <typename Input, typename Value>
Baked<Value> make_bake(BakeKind<Input, Value>& kind, const Input& input, const BakeTask<Value>& task) {
  Baked<Value> kept = kind.load(input);
  if (kept.complete) {
    if (task.progress) task.progress(1.0);
    return kept;
  }
  auto saved = std::chrono::steady_clock::now();
  const BakeTask<Value> watched{task.cancel, task.progress, [&](const Value& part) {
                                  if (task.publish) task.publish(part);
                                  if (std::chrono::steady_clock::now() - saved < kind.save_interval()) return;
                                  kind.save(input, part, false);
                                  saved = std::chrono::steady_clock::now();
                                }};
  const Baked<Value> made = kind.run(input, kept, watched);
  if (made.value && !made.saved) kind.save(input, *made.value, made.complete);
  return made.complete ? made : Baked<Value>{};
}

}  // namespace maquette
