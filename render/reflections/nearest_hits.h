#pragma once

#include <cstdint>
#include <vector>

#include "render/reflections/clusters.h"
#include "render/reflections/reflector_technique.h"

namespace maquette {

/// The nearest triangle that each pixel's mirrored ray meets, among those that a technique offers where it takes them
/// to be seen (shaders/reflections/nearest.glsl): what the projecting techniques share.
class NearestHits {
 public:
  /// Makes what the size of the targets needs, forgets what was found, and binds it for shaders that offer.
  void begin(const ReflectionTargets& targets);
  /// Offers the scene in one plane mirror, as its mirrored eye sees it: exact.
  void offer_planar(const ReflectionFrame& frame, std::size_t reflector, const ClusterSet& clusters);
  /// Looks at the pixels of what was too large to be looked at where it was offered.
  void offer_large(const ReflectionFrame& frame);
  /// Of 8 x 8 pixels each, row by row: how far away the farthest of what the reflector shows there has been found so
  /// far, m; 0 where it is not seen, 1e30 where some ray has met nothing. In storage 2 and texture unit 47.
  void bind_far(const ReflectionFrame& frame, std::size_t reflector);
  std::vector<float> read_far(const ReflectionFrame& frame, std::size_t reflector);
  /// Tells `finish` which group a triangle is of, groups numbered from 0, so that it can say which are seen.
  void set_groups(const std::vector<std::uint32_t>& group_of_triangle, std::size_t count);
  /// Writes `triangle`, `effort` (its channel 0: steps, 1: root) and `doubt` of the targets. `shortest`: bit k set
  /// where only shortest paths in reflector k were looked for. Returns the pixels in doubt.
  unsigned finish(const ReflectionFrame& frame, int channel, unsigned shortest);
  /// Not 0 for the groups of which the picture that was finished last shows something.
  const std::vector<std::uint32_t>& seen_groups() const { return seen_; }
  std::size_t bytes() const {
    return nearest_.bytes() + boxes_.bytes() + counters_.bytes() + list_.bytes() + far_.bytes() + groups_.bytes() +
           seen_buffer_.bytes();
  }

 private:
  void bind() const;
  void reset_boxes();
  void make_boxes(unsigned capacity);
  Buffer nearest_, boxes_, counters_, list_, far_, groups_, seen_buffer_;
  Texture group_view_, nearest_view_, far_view_, box_view_;
  unsigned box_capacity_ = 0;
  std::vector<std::uint32_t> triangles_, seen_;
};

std::vector<ShaderVariant> nearest_hits_shader_variants();

}  // namespace maquette
