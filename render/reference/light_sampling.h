#pragma once

#include <span>

#include "render/reference/light_guide.h"
#include "render/reference/path_sampler.h"
#include "render/reference/path_scene.h"

namespace maquette {

/// A sampled direction towards light. Its estimate is f cos radiance / pdf, times the transmittance. Directions of the
/// environment come without radiance and pdf, so that a blocked ray does not read them from memory:
/// EnvironmentLight::fill does.
struct LightDraw {
  glm::vec3 direction{0.0f};  ///< world, unit
  float distance = 0.0f;      ///< m; infinite for the environment
  glm::vec3 radiance{0.0f};   ///< cd/m2; for lights without extent lux, with pdf the probability of choosing the light
  float pdf = 0.0f;           ///< 1/sr; 0: nothing was drawn
  bool has_extent = true;     ///< BRDF samples can hit it
  int texel = -1;             ///< texel of the environment whose density this direction was drawn with
  int leaf = -1;              ///< leaf of the environment's partition, where a guide drew
};

struct PresampledDirection;
class PresampledEnvironment;

/// The environment, rotated and scaled for this request. With a guide, directions are drawn by what each grid cell can
/// see; with `samples` as well, they come from precomputed directions.
class EnvironmentLight {
 public:
  EnvironmentLight(const TracedEnvironment& environment, const PathOptions& options, LightGuide* guide = nullptr,
                   const PresampledEnvironment* samples = nullptr);
  /// The guide's cell of a position; LightGuide::kNoCell without a guide.
  std::uint32_t cell_of(const glm::vec3& position, const glm::vec3& normal) const;
  /// Prefetches what sampling in this cell reads.
  [[gnu::always_inline]] void prefetch(std::uint32_t cell) const {
    if (cell != LightGuide::kNoCell) guide_->prefetch(cell);
  }
  /// Probabilities of the leaves for a surface of unit `normal` (world) in this cell. Not without a guide.
  void compute_shares(std::uint32_t cell, const glm::vec3& normal, LeafShares* shares) const;
  /// rgb: cd/m2 of a world direction (unit); a: density (1/sr) with which it is drawn. `shares`: null without a guide.
  glm::vec4 radiance_and_density(const glm::vec3& world, const LeafShares* shares = nullptr) const;
  /// Direction and distance only, by plain importance.
  LightDraw draw(const glm::vec2& u) const;
  /// Sampling by what a grid cell can see, in two steps, so that several samples wait for memory together:
  /// choose_directions selects the leaves (or precomputed samples) and prefetches, draw_chosen reads the direction. Of
  /// precomputed samples it reads radiance and pdf as well (`texel` is then -1). `path`: index of the path.
  struct Choice {
    int leaf = -1;
    glm::vec2 within{0.0f};
    const PresampledDirection* sample = nullptr;
    float gain = 1.0f;  ///< of the leaf's density over the plain one
  };
  /// Fills all `choices`, by the first of `numbers`.
  void choose_directions(const PathSampler::Pairs& numbers, std::uint32_t cell, const LeafShares* shares,
                         std::uint32_t path, std::span<Choice> choices) const;
  void draw_chosen(const Choice& choice, LightDraw* draw) const;
  /// Direction and distance of a point of a leaf; `within` in [0, 1)^2.
  LightDraw draw_in_leaf(int leaf, const glm::vec2& within) const;
  /// Computes radiance and pdf of a drawn direction.
  void fill(LightDraw* draw, const LeafShares* shares = nullptr) const;
  /// Records in the guide the transmittance of a sample in `leaf` above the horizon.
  void record(int leaf, std::uint32_t cell, float useful) const;
  bool black() const { return environment_.black; }
  /// Unoccluded illuminance, averaged over all orientations of a surface.
  float mean_lux() const { return mean_lux_; }
  /// The part of mean_lux that is known to arrive in a cell of the guide.
  float known_lux(std::uint32_t cell) const {
    return cell != LightGuide::kNoCell ? mean_lux_ * guide_->openness(cell) : 0.0f;
  }

 private:
  LightDraw draw_at(const EnvironmentPoint& drawn, int leaf) const;

  const TracedEnvironment& environment_;
  float cosine_, sine_, scale_, mean_lux_;
  LightGuide* guide_;
  const PresampledEnvironment* samples_;
};

/// Prefetches what draw_scene_light reads.
void prefetch_scene_light(const PathScene& scene, const LightPick& pick);
/// Samples a point of a chosen light by solid angle. `mean_emission`: a textured triangle emits the mean of its texture
/// (as in the direct modes), else the texture's value at the point.
LightDraw draw_scene_light(const PathScene& scene, const glm::vec3& position, const LightPick& pick, const glm::vec2& u,
                           bool mean_emission);
/// Density with which choose_light and draw_scene_light give a direction from `from` to an emissive triangle. It is the
/// same for all points of the triangle; 0 where the triangle is in no list.
float scene_light_pdf(const PathScene& scene, std::uint32_t triangle, const glm::vec3& from);

}  // namespace maquette
