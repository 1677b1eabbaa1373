#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "render/reflections/clusters.h"
#include "render/reflections/reflector_technique.h"

namespace maquette {

/// The nearest triangle that each pixel's mirrored ray meets, among those that a technique offers where it takes them
/// to be seen (shaders/reflections/nearest.glsl): what the projecting techniques share.
class NearestHits {
 public:
  /// Makes what the size of the targets needs, and forgets what was found.
  void begin(const ReflectionTargets& targets);
  /// Calls `offer(begin, end)` for what is numbered from 0 to `count`, and holds what it has offered against the
  /// pixels' rays: at once, or in parts where there is no memory to list all of it. What has not found room is asked
  /// for again; `accept` is called after what has. Throws Error where a single one is too much.
  void take(const ReflectionFrame& frame, std::size_t count, const std::function<void(std::size_t, std::size_t)>& offer,
            const std::function<void()>& accept);
  /// For a program that offers to a reflector whose rays bind_far has bound: the lists.
  void prepare(const Program& program) const;
  /// For a program that writes what is nearest by itself, as shaders/bezier/points.comp does: at binding 8.
  void bind_nearest() const { glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 8, nearest_.get()); }
  /// Takes the scene in one plane mirror, as its mirrored eye sees it: exact.
  void take_planar(const ReflectionFrame& frame, std::size_t reflector, const ClusterSet& clusters);
  /// Of 8 x 8 pixels each, row by row: the reflector's rays, and how far away the farthest of what it shows there has
  /// been found so far, m; 0 where it is not seen, 1e30 where some ray has met nothing. In texture unit 47.
  void bind_far(const ReflectionFrame& frame, std::size_t reflector);
  /// Not 0 for boxes in the scene (shaders/reflections/visible.comp) that some ray of the reflector may meet before
  /// what has been found for it. Binds what bind_far does.
  std::vector<std::uint32_t> find_visible(const ReflectionFrame& frame, std::size_t reflector, const Buffer& boxes);
  static constexpr std::size_t kVisibleBoxBytes = 48;
  /// Tells `finish` which group a triangle is of, groups numbered from 0, so that it can say which are seen.
  void set_groups(const std::vector<std::uint32_t>& group_of_triangle, std::size_t count);
  /// Writes `triangle`, `effort` (its channel 0: steps, 1: root) and `doubt` of the targets. `shortest`: bit k set
  /// where only shortest paths in reflector k were looked for. Returns the pixels in doubt.
  unsigned finish(const ReflectionFrame& frame, int channel, unsigned shortest);
  /// Not 0 for the groups of which the picture that was finished last shows something.
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
  unsigned tiles_ = 0, list_capacity_ = 0, offer_capacity_ = 0;  ///< nodes with the tiles' heads before them; offers
  unsigned listed_ = 0, offered_ = 0;                            ///< what the last offers needed
  std::vector<std::uint32_t> triangles_, seen_;
};

std::vector<ShaderVariant> nearest_hits_shader_variants();

}  // namespace maquette
