#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "render/gl/bindings.h"
#include "render/reflections/clusters.h"
#include "render/reflections/reflector_technique.h"

namespace maquette {

/// The nearest triangle that the mirrored ray of each pixel hits. A technique offers candidates with the area of the
/// screen where they may be visible (shaders/reflections/nearest.glsl). Shared by the projecting techniques.
class NearestHits {
 public:
  /// Allocates for the size of the targets, and discards previous hits.
  void begin(const ReflectionTargets& targets);
  /// Calls `offer(begin, end)` for elements 0 to `count`, and intersects the triangles that it offers with the pixels'
  /// rays: all at once, or in parts when memory cannot hold the lists of all. A part that did not fit is offered again;
  /// `accept` is called after each part that did. Throws Error when a single element does not fit.
  void find_nearest(const ReflectionFrame& frame, std::size_t count,
                    const std::function<void(std::size_t, std::size_t)>& offer, const std::function<void()>& accept);
  /// Binds the lists for a program that offers triangles, after bind_far of their reflector.
  void prepare(const Program& program) const;
  /// For a program that writes the nearest hits itself (shaders/bezier/points.comp).
  void bind_nearest() const { glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kBufferNearest, nearest_.get()); }
  /// Finds the hits in one plane mirror from the reflected eye: exact.
  void find_nearest_planar(const ReflectionFrame& frame, std::size_t reflector, const ClusterSet& clusters);
  /// Binds, for tiles of 8 x 8 pixels, row by row, the reflector's rays and the largest distance of the hits found so
  /// far, m; 0 where the reflector is not visible, 1e30 where some ray has no hit. At kUnitFarTiles.
  void bind_far(const ReflectionFrame& frame, std::size_t reflector);
  /// Tests boxes in the scene (shaders/reflections/visible.comp): not 0 when a ray of the reflector may hit the box
  /// before the nearest hit so far. Also binds what bind_far does.
  std::vector<std::uint32_t> find_visible(const ReflectionFrame& frame, std::size_t reflector, const Buffer& boxes);
  static constexpr std::size_t kVisibleBoxBytes = 48;
  /// Assigns triangles to groups, numbered from 0, for seen_groups().
  void set_groups(const std::vector<std::uint32_t>& group_of_triangle, std::size_t count);
  /// Writes `triangle`, `effort` (its channel 0: steps, 1: root) and `low_confidence` (pixels of low confidence) of the
  /// targets. `shortest`: bit k is set where only shortest paths in reflector k were searched. Returns the number of
  /// uncertain pixels.
  unsigned finish(const ReflectionFrame& frame, int channel, unsigned shortest);
  /// Not 0 for groups with a visible triangle in the picture of the last finish().
  const std::vector<std::uint32_t>& seen_groups() const { return seen_; }
  std::size_t bytes() const {
    return nearest_.bytes() + lists_.bytes() + offers_.bytes() + large_.bytes() + counters_.bytes() +
           triangle_list_.bytes() + far_.bytes() + groups_.bytes() + seen_buffer_.bytes();
  }

 private:
  static void run_groups(const ReflectionFrame& frame, const ShaderVariant& variant, int count);
  void clear_lists();
  bool resolve(const ReflectionFrame& frame);
  bool grow();
  Buffer nearest_, lists_, offers_, large_, counters_, triangle_list_, far_, groups_, seen_buffer_;
  Texture group_view_, list_view_, offer_view_, far_view_;
  unsigned tiles_ = 0;
  unsigned list_capacity_ = 0, offer_capacity_ = 0;  ///< list nodes, including the heads of the tiles; offers
  unsigned listed_ = 0, offered_ = 0;                ///< capacities that the last offers needed
  std::vector<std::uint32_t> triangles_, seen_;
};

std::vector<ShaderVariant> nearest_hits_shader_variants();

}  // namespace maquette
