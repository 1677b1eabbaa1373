#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/reflections/mirrored_rays.h"
#include "render/reflections/reflected_picture.h"
#include "render/reflections/skipping.h"
#include "scenes/image.h"

namespace maquette {

/// What panes and mirrors show of the scene: their rays, the hits that a technique finds, and the hits' shading.
class Reflections {
 public:
  /// What the plan should know: why all rays are followed.
  void report(const FrameRequest& request, const Technique& technique, const SceneState& scene,
              const ReflectorSet& reflectors, bool traced, FrameStatus* status);
  /// Nothing is mirrored in this frame.
  void rest() { traced_.reset(); }
  /// What carries out the passes from `panes` to `reflected shade`. `surfaces`: all that the G-buffer depends on.
  /// `behind`: what is seen through the panes.
  /// `averages_points`: what is shown at rest is averaged here; the other modes average whole pictures.
  Pass pass(const MirroredScene& scene, const Technique& technique, bool averages_points, std::function<Key()> surfaces,
            std::function<const Texture&()> behind);
  /// Binds the reflected pictures for panes and mirrors (shaders/glass).
  ReflectedPicture bind(const Settings& settings);

  void add_bytes(const ReflectorSet& reflectors, std::map<std::string, std::size_t>* bytes) const;
  void add_counters(const ReflectorSet& reflectors, std::map<std::string, double>* counters) const;
  static std::vector<ShaderVariant> shader_variants();
  static std::vector<DebugViewInfo> views();
  /// A debug view of the reflected picture, at its size. `drawn`: this frame has one. Throws Error when there is none.
  std::optional<Image> view(const std::string& name, bool drawn, const FrameConstants& frame) const;

 private:
  struct Frame {
    const MirroredScene& scene;
    const Texture& behind;
    bool averages = false;   ///< see FollowRule
    bool continues = false;  ///< the rays are those of the frame before
    bool kept = false;       ///< and so are their hits
    int varies = 0;          ///< number of the frame at rest, whose rays vary over pixels and lobes; 0: they do not
  };
  void run(const Frame& frame);
  void draw_panes(const Frame& frame, const ReflectionTargets& targets);
  void cast_rays(const Frame& frame, MirroredRays* rays, bool ghost);
  void set_variation(const Frame& frame, const Program& rays);
  void bind_ghost(const Frame& frame, const Program& rays);
  void drop_unseen_rays(const Frame& frame);
  void follow(const Frame& frame, MirroredRays* rays, bool ghost);
  Image read_picture(const MirroredRays& rays, int channel) const;

  MirroredRays rays_, ghost_, probes_;  ///< the picture; of panes' back faces; fewer rays, where some are not followed
  Buffer ghost_reach_;                  ///< by reflector, as ReflectionFrame has it
  Buffer fit_reach_;                    ///< by patch
  std::string technique_name_;
  std::unique_ptr<ReflectorTechnique> technique_;
  std::optional<Key> traced_;  ///< what the rays are of; empty: nothing that holds
  Skipping skipping_;
  bool skips_ = false;  ///< some rays of this frame are not followed
};

}  // namespace maquette
