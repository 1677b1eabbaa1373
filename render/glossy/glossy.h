#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/reflections/mirrored_rays.h"
#include "scenes/image.h"

namespace maquette {

/// What glossy opaque surfaces mirror of the scene, by a reflector technique that follows single rays;
/// docs/reflections.md says which light that is. Of the default mode's layer. At rest an exact technique gets another
/// ray in each frame.
class Glossy {
 public:
  /// Frees all.
  void clear();
  /// Nothing of it is drawn: frees the images. What rays meet is kept, because a window that switches between two modes
  /// would build it each time (0.2 s for the cockpit).
  void rest();
  /// What carries out the pass `glossy`. `surfaces`: all that the G-buffer depends on. `averages_points`: of the mode;
  /// the other modes average whole pictures.
  void run(const MirroredScene& scene, const Technique& technique, const Key& surfaces, bool averages_points);
  /// RGBA32F, cd/m2: what mirroring changes at each point of the grid.
  const Texture& light() const { return light_; }
  std::size_t bytes() const { return rays_.bytes() + light_.bytes() + tiles_.tiles.bytes(); }
  void add_counters(std::map<std::string, double>* counters) const { technique_->add_counters(counters); }
  static std::vector<ShaderVariant> shader_variants();
  /// What the rays met, cd/m2; alpha 0 where there is none.
  Image view() const;

 private:
  void find_tiles(const MirroredScene& scene);
  void cast_rays(const MirroredScene& scene, bool exact);
  void set_uniforms(const MirroredScene& scene, const Program& program) const;

  MirroredRays rays_;
  TileList tiles_;  ///< where there may be such surfaces
  TileCounter counter_;
  Texture light_;
  std::string technique_name_;
  std::unique_ptr<ReflectorTechnique> technique_;
  std::optional<Key> traced_;  ///< what the hits are of
};

/// Items among the named nodes that are no mirrors, but smooth enough to be named.
std::vector<std::size_t> named_glossy_items(const SceneState& scene, const ReflectorSet& reflectors,
                                            const std::vector<std::string>& names);
/// Items that may mirror so and be seen.
int glossy_in_view(const SceneState& scene, const ReflectorSet& reflectors, const FrameRequest& request,
                   const glm::mat4& clip_from_world);

}  // namespace maquette
