#pragma once

#include <optional>
#include <vector>

#include "render/shading/shading_mode.h"
#include "render/shading/work_lists.h"

namespace maquette {

/// The shaders' VISIBILITY: 0 none, 1 baked, 2 traced.
std::string visibility_define(const ShadingPlan& plan);
ShaderVariant shade_variant(const ShadingPlan& plan, bool measured);
/// Of shaders that leave the sun out of their samples (SEPARATE_SUN).
void set_sun(const Program& program, const SunBuffers& sun);
/// `textures`: points are kept without their base factor (shaders/bandwidth/base_factor.glsl).
ShaderVariant gather_variant(bool accumulate, bool textures);

/// Shading by samples of work lists, shared by the modes that integrate the environment: points are marked and listed,
/// their items shaded, and the items of a point gathered into its radiance.
class SampledShading {
 public:
  /// `predicted`: of make_work_lists.
  void fit(const GridSize& size, bool predicted);
  WorkLists& lists() { return lists_; }
  const WorkLists& lists() const { return lists_; }
  const Texture& marks() const { return marks_; }

  /// How the shader that marks (bandwidth/mark.comp) is set up for one band, beside what all have in common.
  struct Marking {
    const Program& program;
    const TileList& tiles;
    unsigned most_items;  ///< of each list; scales the counts down where they ask for more
  };
  /// Lists the points of a band and their items; `counters` as in shaders/bandwidth/mark.comp.
  void mark_band(const Marking& marking, std::size_t band, unsigned counters[16]);
  /// Shades the items of both lists and gathers them by `gather` into what image 0 is bound to.
  void shade_lists(const FrameContext& frame, const ShadingPlan& plan, const unsigned counters[16],
                   ShaderVariant (*variant)(const ShadingPlan&, bool measured), const Program& gather);
  /// See ShadingMode::shade_hits.
  void shade_hits(const HitShading& hits);

  static std::vector<ShaderVariant> shader_variants();
  std::size_t bytes() const { return lists_.bytes() + marks_.bytes(); }
  ShadingCounts counts;

 private:
  void shade_hit_rows(const HitShading& hits, int first_row, int rows);

  WorkLists lists_;
  Texture marks_;  ///< RGBA8UI: shaded, level, log2 of samples, 1 if visible
};

/// Lanes of views that every sampled mode has: `shaded`, `level`, `samples`.
std::optional<PointValue> view_of_marks(const std::string& name, const Texture& marks);

}  // namespace maquette
