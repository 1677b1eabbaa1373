#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/gl/objects.h"
#include "render/math/shared_formulas.h"
#include "render/reflections/mirrored_bound.h"
#include "render/reflections/mirrored_rays.h"

namespace maquette {

/// Which mirrored rays are not followed, because what they bring is invisible before what is seen through the pane.
class Skipping {
 public:
  /// Why all rays of a frame with this technique are followed, or empty: some are left out. `traced`: shading takes
  /// rays through the octree.
  static std::string why_all(const FrameRequest& request, const Technique& technique, const ReflectorSet& reflectors,
                             bool traced);
  /// Nothing is kept.
  void clear();
  /// Brings the bounds of what parts of the panes mirror up to date with the geometry. False while that changes from
  /// frame to frame: all rays are then followed.
  bool update_geometry(const SceneState& scene, const ReflectorSet& reflectors);
  /// The same with the light, and for the eye of this frame.
  void update_light(const FrameContext& frame, bool shadows);
  /// Draws how much of what is behind the panes is seen, in the size of `targets`.
  void draw_cover(const MirroredScene& scene, const ReflectionTargets& targets);
  /// Marks the rays of `targets` that need not be followed, by what `probes` met with a ray for `spacing` x `spacing`.
  /// `behind`: what is seen through the panes.
  void mark(const MirroredScene& scene, const ReflectionTargets& targets, const ReflectionTargets& probes, int spacing,
            const Texture& behind);

  void add_counters(std::map<std::string, double>* counters) const;
  std::size_t bytes() const { return parts_.bytes() + bounds_.bytes() + counters_.bytes() + cover_.bytes(); }
  static std::vector<ShaderVariant> shader_variants();

 private:
  struct Lobe {
    shared::AnalyticMaterial material{};
    LobeBound bound;
  };
  /// Index in `lobes` of the bound of a material's lobe, which is added.
  int lobe_of(SceneState* scene, std::size_t material, std::vector<LobeBound>* lobes);
  void set_light(SceneState* scene, const FrameRequest& request, bool shadows);
  void bind(const MirroredScene& scene, const ReflectionTargets& probes, const Texture& behind, const Program& program);

  MirroredBound bound_;
  std::optional<Key> geometry_;                 ///< that `bound_` is of
  std::optional<std::uint32_t> seen_geometry_;  ///< of the frame before: while geometry changes nothing is skipped
  std::optional<Key> light_;                    ///< that `bound_` is of
  std::shared_ptr<const Environment> environment_;
  SkyBound sky_;                              ///< of it
  std::vector<Lobe> lobes_;                   ///< of analytic materials met so far
  std::optional<glm::mat4> clip_from_world_;  ///< that the bounds on the GPU are for
  Buffer parts_, bounds_, counters_;
  Texture part_view_, bound_view_, cover_;
  GlName<FramebufferTraits> framebuffer_;
};

}  // namespace maquette
