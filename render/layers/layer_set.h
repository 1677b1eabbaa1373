#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "render/indirect/indirect_pass.h"
#include "render/parts/parts.h"
#include "render/shading/layer.h"
#include "render/shadow_rays/shadow_pass.h"

namespace maquette {

/// One layer of the frame, kept from frame to frame: a mode, the surfaces that it shades, and what it makes of them.
struct Layer {
  std::string mode_name;
  std::unique_ptr<ShadingMode> mode;
  Surfaces surfaces;
  Texture radiance;       ///< RGBA32F, of the grid
  Texture own_triangles;  ///< of the raster, where several layers share it
  IndirectPass indirect;
  ShadowPass shadows;
  FrameConstants constants{};
  Buffer block = Buffer("frame constants", sizeof(FrameConstants));

  void bind() const;
  void add_bytes(std::map<std::string, std::size_t>* bytes) const;
};

/// The layers of the frame at hand.
class LayerSet {
 public:
  /// Makes those anew that are of another mode or size; others stay. True when any was made: nothing of the frame
  /// before is left there. `made`: called with the index of each.
  bool fit(const FramePlan& wanted, const GridSize& size, const Registry& registry,
           const std::function<void(int)>& made);
  std::size_t size() const { return layers_.size(); }
  Layer& operator[](std::size_t k) { return *layers_[k]; }
  const Layer& operator[](std::size_t k) const { return *layers_[k]; }

  /// How all of them can go on from the frame before.
  Continuation compare(const FrameChange& change) const;
  void begin(const FrameStart& start, FrameStatus* status);
  /// `base`: what all have in common.
  void set_constants(const FrameConstants& base, const FrameStart& start, const FramePlan& plan);
  ShadingCounts counts() const;
  void clear();
  /// Of the modes that rest.
  void add_bytes_at_rest(std::map<std::string, std::size_t>* bytes) const;

 private:
  void rest(std::unique_ptr<Layer>* layer);

  std::vector<std::unique_ptr<Layer>> layers_;
  std::map<std::string, std::unique_ptr<ShadingMode>> at_rest_;  ///< by name: ShadingMode::keeps_tables
};

/// What carries out the passes of the G-buffer and of indirect light of a layer.
std::vector<Pass> surface_passes(const LayerContext& context, Layer* layer, const Parts& parts, SkyTiles* sky);
Pass indirect_pass(const LayerContext& context, Layer* layer);
/// `averages`: as ShadowPass::run.
Pass shadow_pass(const LayerContext& context, Layer* layer, bool averages);

}  // namespace maquette
