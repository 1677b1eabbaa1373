#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "render/frame/context.h"
#include "render/frame/pass.h"
#include "render/reflections/targets.h"

namespace maquette {

/// What a frame knows of the one before when it begins.
struct FrameChange {
  const FrameRequest& request;
  bool accumulate = false;     ///< the picture is to be the mean with those before
  bool same_request = false;   ///< as the frame before
  bool nothing_moved = false;  ///< in scene, materials, environment and bakes
  Key points;                  ///< all that points depend on besides request, measured tables and indirect light
};

/// How a mode can go on from the frame before.
struct Continuation {
  bool accumulates = true;    ///< what it holds can be added to
  bool keeps_points = false;  ///< points hold where no measured table was swapped
};

/// Of a frame, once it is known how it goes on.
struct FrameStart {
  const FrameRequest& request;
  const SceneState& scene;
  Key points;  ///< as in FrameChange
  bool accumulate = false;
  int accumulated = 0;    ///< frames in the picture so far
  bool repaints = false;  ///< only the points of materials with swapped tables are shaded anew
};

/// Points and samples of a frame.
struct ShadingCounts {
  std::size_t visible = 0, shaded = 0, samples = 0;
};

/// Hits of mirrored rays that are to be shaded: `targets.tiles` lists where there are some, unit 9 has their depths
/// along the rays, 0 where another mode shades them. The frame block on binding 0 has the size of the targets.
struct HitShading {
  const FrameContext& frame;
  const ShadingPlan& plan;
  const ReflectionTargets& targets;
  int panes = 0;  ///< bit k: reflector k lets light through, so that its pixels take fewer samples than a mirror's
  bool without_sun = false;  ///< shadow rays bring its light
};

/// What composing a layer needs to know of how its mode leaves the radiance.
struct ComposeInfo {
  bool without_base_factor = false;  ///< points are divided by their base colour (shaders/bandwidth/base_factor.glsl)
  /// With several points a pixel: quads that are one value, and the others; null: all points are filled.
  const QuadList* plain_quads = nullptr;
  const QuadList* mixed_quads = nullptr;
};

/// What a debug view shows at each grid point.
using PointValue = std::function<glm::vec3(int x, int y)>;

/// A shading mode at work on one layer, with all that it keeps from frame to frame.
class ShadingMode {
 public:
  virtual ~ShadingMode() = default;
  /// Grid rows of a band of the layer's tile lists.
  virtual int band_rows(const GridSize& size) const = 0;
  /// The layer's surfaces have this size from now on: what was kept of others is gone.
  virtual void fit(const GridSize& size) = 0;
  /// Has tables of light or materials that took long and know by themselves whether they are stale: it is kept while
  /// another mode draws, or another size is made.
  virtual bool keeps_tables() const { return false; }
  virtual Continuation compare(const FrameChange&) const { return {}; }
  /// Called before the plan is made; writes what the plan should know into `status`.
  virtual void begin(const FrameStart&, FrameStatus* /*status*/) {}
  /// Sets what of the frame's constants is the mode's own: levels, samples, quality.
  virtual void set_constants(const FrameStart& start, const ShadingPlan& plan, FrameConstants* constants) const = 0;
  /// Called when constants and light samples are set, before the passes.
  virtual void prepare(const FrameStart&, const LayerContext&) {}
  /// What carries out the passes that its technique plans.
  virtual std::vector<Pass> passes(const LayerContext& layer) = 0;
  /// Tiles that this frame changed, for what is drawn over all of a layer and kept. Null: all that show a surface.
  virtual const TileList* changed_tiles() const { return nullptr; }
  /// Called when the frame is complete.
  virtual void end(const FrameStart&) {}
  /// Writes radiance and marks of the hits.
  virtual void shade_hits(const HitShading& hits) = 0;
  /// Samples of the environment for cells with BRDFs, which are shaded beside the hits; 0: as many as hits take.
  virtual int samples_of_cells() const { return 0; }
  virtual ShadingCounts counts() const = 0;
  virtual ComposeInfo compose_info(const SceneState&) const { return {}; }
  /// Bytes of its own by vocabulary word, added to what is there; counters of the last frame.
  virtual void add_bytes(std::map<std::string, std::size_t>*) const {}
  virtual void add_counters(std::map<std::string, double>*) const {}
  /// A debug view of its technique: values at the points of its layer. Nothing when it has none of that name.
  virtual std::optional<PointValue> view(const std::string& /*name*/, const LayerContext&) const { return {}; }
  /// What such a view shows where no layer has a surface; nothing: it is transparent there.
  virtual PointValue sky_view(const std::string& /*name*/, const LayerContext&) const { return {}; }
};

/// Samples that `--samples`, or else this setting, asks for.
inline int asked_samples(const FrameRequest& request, const std::string& setting) {
  return request.samples > 0 ? request.samples : request.settings.get_int(setting);
}

}  // namespace maquette
