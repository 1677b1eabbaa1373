#pragma once

namespace maquette {

/// Gives the picture smooth edges once nothing moves, by more samples a pixel. The previous picture stays on screen
/// until the new one has no more noise.
class StillEdges {
 public:
  static constexpr double kRest_s = 1.5;  ///< shorter rests are often only pauses in a move
  static constexpr int kMostHeld = 8;     ///< the previous picture stays on screen for at most this many frames

  struct Input {
    int moving_samples = 1, still_samples = 1;  ///< a pixel
    bool changed = false;                       ///< the picture differs from that of the last iteration
    bool disturbed = false;                     ///< and nothing of the previous one can be kept
    bool may_begin = true;                      ///< no other work needs the picture as it is
    int frames = 0;                             ///< averaged so far
    double now_s = 0.0;
  };
  /// Samples a pixel of the next frame.
  int next_samples(const Input& input);
  /// The mean of the first `frames` frames is still noisier than the picture on screen.
  bool hidden(int frames) const { return smooth_ && frames < held_; }
  /// That many samples could not be drawn: they are not tried again until something changes.
  void refuse();
  bool smooth() const { return smooth_; }

 private:
  bool smooth_ = false, refused_ = false;
  int held_ = 0;  ///< number of frames averaged in the picture on screen
  double rest_begin_s_ = 0.0;
};

}  // namespace maquette
