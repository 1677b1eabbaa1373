#pragma once

#include <span>

#include "render/reference/light_guide.h"
#include "render/reference/path_sampler.h"
#include "render/reference/path_scene.h"

namespace maquette {

/// A direction towards light, drawn by importance. What it brings: f cos radiance / pdf, times what comes through.
/// Directions of the environment come without radiance and pdf, which wait in memory that a blocked ray need not touch:
/// EnvironmentLight::fill reads them.
struct LightDraw {
  glm::vec3 direction{0.0f};  ///< world, unit
  float distance = 0.0f;      ///< m; infinite for the environment
  glm::vec3 radiance{0.0f};   ///< cd/m2; for lights without extent lux, with pdf the probability of choosing the light
  float pdf = 0.0f;           ///< 1/sr; 0: nothing was drawn
  bool has_extent = true;     ///< BRDF samples can hit it
  int texel = -1;             ///< of the environment, whose density this direction was drawn with
  int leaf = -1;              ///< of the environment's partition, where a guide drew
};

struct PresampledDirection;
class PresampledEnvironment;

/// The environment as this request turns and scales it; with a guide, drawn by what each place can see, and then with
/// `samples` from directions that were drawn before.
class EnvironmentLight {
 public:
  EnvironmentLight(const TracedEnvironment& environment, const PathOptions& options, LightGuide* guide = nullptr,
                   const PresampledEnvironment* samples = nullptr);
  /// Where the guide keeps what it knows of this place; LightGuide::kNoCell without a guide.
  std::uint32_t cell_of(const glm::vec3& position, const glm::vec3& normal) const;
  /// Fetches what drawing in this cell reads, ahead of time.
  [[gnu::always_inline]] void prefetch(std::uint32_t cell) const {
    if (cell != LightGuide::kNoCell) guide_->prefetch(cell);
  }
  /// What a surface of unit `normal` (world) in this cell draws by. Not without a guide.
  void look(std::uint32_t cell, const glm::vec3& normal, LeafShares* shares) const;
  /// cd/m2 of a world direction (unit), and 1/sr with which it is drawn; `shares`: null without a guide.
  glm::vec4 radiance_and_density(const glm::vec3& world, const LeafShares* shares = nullptr) const;
  /// Direction and distance only, by plain importance.
  LightDraw draw(const glm::vec2& u) const;
  /// By what a place can see, in parts, so that several draws wait for memory together: first where to look, then the
  /// direction and, of samples drawn before, the rest (`texel` is -1). `path`: whose draw it is.
  struct Choice {
    int leaf = -1;
    glm::vec2 within{0.0f};
    const PresampledDirection* sample = nullptr;
    float gain = 1.0f;  ///< of the leaf's density
  };
  /// As many as there are `choices`, by the first of `numbers`.
  void choose(const PathSampler::Pairs& numbers, std::uint32_t cell, const LeafShares* shares, std::uint32_t path,
              std::span<Choice> choices) const;
  void take(const Choice& choice, LightDraw* draw) const;
  /// Direction and distance of a point of a leaf; `within` as `draw`'s numbers.
  LightDraw draw_in_leaf(int leaf, const glm::vec2& within) const;
  /// Radiance and pdf of what was drawn.
  void fill(LightDraw* draw, const LeafShares* shares = nullptr) const;
  /// Tells the guide what came through of a draw in `leaf` above the horizon.
  void record(int leaf, std::uint32_t cell, float useful) const;
  bool black() const { return environment_.black; }
  /// Mean over all directions that a surface may face, nothing in between.
  float mean_lux() const { return mean_lux_; }
  /// Of that, what is known to arrive in a cell of the guide.
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

/// Asks for what draw_scene_light reads.
void prefetch_scene_light(const PathScene& scene, const LightPick& pick);
/// A point of a light that was chosen, by solid angle. `mean_emission`: a textured triangle shines with its mean (as
/// the direct modes have it), else as its texture says there.
LightDraw draw_scene_light(const PathScene& scene, const glm::vec3& position, const LightPick& pick, const glm::vec2& u,
                           bool mean_emission);
/// Density with which choose_light and draw_scene_light give a direction from `from` to an emissive triangle: the same
/// for all its points, 0 where it is in no list.
float scene_light_pdf(const PathScene& scene, std::uint32_t triangle, const glm::vec3& from);

}  // namespace maquette
