#pragma once

namespace maquette {

/// Gives the picture smooth edges once it rests: more samples a pixel than while something moves, drawn behind the
/// picture so far until they are no noisier than it.
class StillEdges {
 public:
  static constexpr double kRest_s = 1.5;  ///< what looks like the end of a move often is a pause
  static constexpr int kMostHeld = 8;     ///< frames for which the picture so far stays in sight

  struct Turn {
    int moving_samples = 1, still_samples = 1;  ///< a pixel
    bool changed = false;                       ///< the picture will be another one than in the turn before
    bool disturbed = false;                     ///< and nothing of the one before can be kept
    bool may_begin = true;                      ///< nothing else waits for the picture as it is
    int frames = 0;                             ///< averaged so far
    double now_s = 0.0;
  };
  /// Samples a pixel of the next frame.
  int choose(const Turn& turn);
  /// The frames so far, `frames` of them, are still noisier than the picture in sight.
  bool hidden(int frames) const { return smooth_ && frames < held_; }
  /// So many samples could not be drawn: not again until something changes.
  void refuse();
  bool smooth() const { return smooth_; }

 private:
  bool smooth_ = false, refused_ = false;
  int held_ = 0;  ///< frames that the picture in sight is worth
  double rest_begin_s_ = 0.0;
};

}  // namespace maquette
