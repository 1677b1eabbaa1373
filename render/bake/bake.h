#pragma once

#include <cstddef>

namespace maquette {

enum class BakeState {
  absent,   ///< nothing is there and nothing is in work
  running,  ///< nothing is there yet
  partial,  ///< there is a part to draw with
  ready,    ///< whole; a newer one may be in work (Bake::busy)
  failed,   ///< the last run threw
};

/// What a list of bakes, the status line and those who wait know of a bake, whatever it holds and however it is made.
/// Of one thread; the work itself runs on another.
class Bake {
 public:
  virtual ~Bake() = default;
  /// A word of the vocabulary: `visibility`.
  virtual const char* name() const = 0;
  virtual BakeState state() const = 0;
  /// There is something to draw with, if only a part or that of the state before.
  virtual bool ready() const = 0;
  virtual bool busy() const = 0;
  /// Of the run in work, in [0, 1].
  virtual double progress() const = 0;
  /// Until the run in work is done or failed; the owner's next update takes it over.
  virtual void wait() = 0;
  /// Ends the run in work, without waiting; what was there stays.
  virtual void cancel() = 0;
  /// Of what is drawn with, on the device or in memory.
  virtual std::size_t bytes() const = 0;

 protected:
  Bake() = default;
  Bake(const Bake&) = default;
  Bake& operator=(const Bake&) = default;
};

}  // namespace maquette
