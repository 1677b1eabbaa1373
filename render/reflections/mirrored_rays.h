#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "render/parts/parts.h"
#include "render/reflections/mirrored_layer.h"
#include "render/reflections/reflector_set.h"
#include "render/reflections/reflector_technique.h"
#include "render/reflections/targets.h"
#include "render/shading/layer.h"
#include "render/shadow_rays/hit_shadows.h"

namespace maquette {

/// Points of the grid along one side of a pixel of the reflected picture. `at_rest`: nothing has moved since the frame
/// before.
int reflection_divisor(const Settings& settings, bool at_rest);

/// The frame's layers, and what is handed to all that mirrors them.
struct MirroredScene {
  const FrameContext& frame;
  const std::vector<DrawnLayer>& layers;
  const Parts& parts;
  ReflectorSet& reflectors;
  const Texture& depth;                 ///< R32F, of all layers, m along the viewing axis
  std::function<void(int)> bind_layer;  ///< binds again what shaders of a layer read
};

/// How the hits of one image of mirrored rays are found and shaded.
struct FollowRule {
  ReflectorTechnique& technique;
  bool keeps_hits = false;   ///< those of the frame before hold: they are only shaded anew
  bool glossy = false;       ///< rays of opaque surfaces: they name materials, not reflectors
  bool lists_tiles = true;   ///< those of the rays are not listed yet
  bool finds_tint = true;    ///< what panes on the way of the rays leave; else the targets have it, or none
  bool shadow_rays = false;  ///< sun and lamps are shadowed by them where the plan has them
  bool averages = false;     ///< at rest, what is shown is the mean over the frames
  bool continues = false;    ///< the mean of the frames before goes on
  const std::vector<GhostDeviation>* ghost = nullptr;  ///< see ReflectionFrame
  const std::vector<FitDeviation>* fits = nullptr;
};

/// One image of mirrored rays, from rays to radiance: a technique finds what they hit, and the modes of the parts that
/// are hit shade it.
class MirroredRays {
 public:
  /// Makes the images anew where they are not of the grid's size.
  void fit(const GridSize& grid, int divisor);
  void clear() {
    targets_.reset();
    shadows_.clear();
    layer_.reset();
  }
  bool has_images() const { return targets_.has_value(); }
  ReflectionTargets& targets() { return *targets_; }
  const ReflectionTargets& targets() const { return *targets_; }
  std::size_t bytes() const {
    return (targets_ ? reflection_bytes(*targets_) : 0) + shadows_.bytes() + (layer_ ? layer_->bytes() : 0);
  }
  /// Binds the frame block at the size of this image, and the reflectors. `samples`: of a shaded point.
  void bind_constants(const MirroredScene& scene) {
    bind_constants(scene, scene.frame.request.settings.get_int("reflections.samples"));
  }
  void bind_constants(const MirroredScene& scene, int samples);
  const FrameConstants& constants() const { return constants_; }
  /// Lists the tiles that show a reflector, or that have rays.
  void list_tiles(ProgramCache* programs, bool rays);
  /// From rays to radiance.
  void follow(const MirroredScene& scene, const FollowRule& rule);
  static std::vector<ShaderVariant> shader_variants();

 private:
  ReflectionFrame reflection_frame(const MirroredScene& scene, const FollowRule& rule,
                                   const std::vector<bool>& occluding);
  void find_hits(const MirroredScene& scene, const FollowRule& rule, const ReflectionFrame& frame);
  /// What panes on the way of the rays leave, once it can be told.
  void find_tint(const MirroredScene& scene, const FollowRule& rule);
  void shade_hits(const MirroredScene& scene, const FollowRule& rule);
  /// Whether shadow rays bring light to the hits of a layer.
  static bool shadowed_by_rays(const ShadingPlan& plan, const FollowRule& rule);
  static bool rays_shadow_any(const MirroredScene& scene, const FollowRule& rule);
  void complete(const MirroredScene& scene, const FollowRule& rule, const ReflectionFrame& frame);
  /// Adds what blended surfaces before the hits show, each order along the rays shaded as hits are.
  void add_layers(const MirroredScene& scene, const FollowRule& rule);
  /// The mean over the frames at rest takes the place of this frame's light.
  void average(const MirroredScene& scene, const FollowRule& rule);
  int frames_in_mean(const FollowRule& rule) const { return rule.continues ? frames_ + 1 : 1; }

  std::optional<ReflectionTargets> targets_;
  FrameConstants constants_{};
  HitShadows shadows_;
  int frames_ = 0;  ///< in the mean
  Buffer block_, tile_count_;
  MirroredLayers layers_;                ///< of the hits
  std::unique_ptr<MirroredRays> layer_;  ///< the rays of one of them; null while nothing blends
};

}  // namespace maquette
