#pragma once

#include <array>

namespace maquette {

/// Chooses the resolution of the picture while something moves, from measured frame times. While the environment
/// rotates, points reuse results of earlier frames (render/bandwidth/temporal_reuse.h) as long as the size stays the
/// same. So such frames are measured separately, and a size is changed only after it was too slow twice in a row.
class MovingScale {
 public:
  enum class Kind { light, other };
  static constexpr double kFluid_ms = 100.0;  ///< a slower moving frame gets coarser

  /// Of the next frame; `full_px`: pixels at scale 1; `most`: the largest scale allowed, in (0, 1].
  float next_scale(Kind kind, double full_px, float most);
  /// Records the time of a moving frame of `px` pixels.
  void note(Kind kind, double ms, double px);
  /// Records the time of a frame while nothing moved: the estimate for moves until one has been measured.
  void note_still(double ms, double px);
  /// The move is over.
  void rest() { moving_ = false; }

 private:
  struct Cost {
    double ms_per_px = 0.0;  ///< 0: not known
    int slow = 0;            ///< consecutive frames that took too long
  };
  Cost& cost(Kind kind) { return costs_[kind == Kind::light ? 0 : 1]; }
  std::array<Cost, 2> costs_;
  double still_ms_per_px_ = 0.0;
  bool moving_ = false;
  Kind kind_ = Kind::other;
  float scale_ = 1.0f;
};

}  // namespace maquette
