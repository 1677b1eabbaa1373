#pragma once

#include <array>

namespace maquette {

/// Chooses how coarse the picture is while something moves, by what frames took. While the light turns, points go on
/// from their past (render/bandwidth/turning.h) as long as the size stays, so such frames are judged apart from the
/// others, and a size is left only when it was too slow twice in a row.
class MovingScale {
 public:
  enum class Kind { light, other };
  static constexpr double kFluid_ms = 100.0;  ///< what a moving frame may take before it gets coarser

  /// Of the next frame; `full_px`: pixels at scale 1; `most`: the largest scale allowed, in (0, 1].
  float choose(Kind kind, double full_px, float most);
  /// What a frame of a move took, of `px` pixels.
  void note(Kind kind, double ms, double px);
  /// What a frame took that was drawn while nothing moved: what is known of other moves until one is seen.
  void note_still(double ms, double px);
  /// The move is over.
  void rest() { moving_ = false; }

 private:
  struct Cost {
    double ms_per_px = 0.0;  ///< 0: not known
    int slow = 0;            ///< frames in a row that took too long
  };
  Cost& cost(Kind kind) { return costs_[kind == Kind::light ? 0 : 1]; }
  std::array<Cost, 2> costs_;
  double still_ms_per_px_ = 0.0;
  bool moving_ = false;
  Kind kind_ = Kind::other;
  float scale_ = 1.0f;
};

}  // namespace maquette
