#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/technique/registry.h"
#include "render/renderer.h"
#include "viewer/options.h"
#include "viewer/report/data.h"

/// What a report measures: cameras, techniques from the registry, their quality steps.
namespace maquette::report {

struct SweptCamera {
  std::string name;
  CameraView view;
};
/// All cameras of the scene, or the one of the options; without any, a view of the whole scene named `overview`.
/// Cameras of one name get numbers.
std::vector<SweptCamera> swept_cameras(const Scene& scene, const SceneOptions& options);

struct SweptTechnique {
  std::string name;
  std::string help;
  TechniqueKind kind = TechniqueKind::mode;
  std::vector<QualityStep> steps;      ///< at least one
  std::optional<std::string> refused;  ///< why it cannot draw this scene with these settings
  std::string mode;                    ///< that draws it; reflection_mode() for a reflector technique
  std::string visibility;              ///< replaces shading.visibility; empty: as requested
};
/// Every registered mode and reflector technique, those that cannot draw the scene with the reason; where something
/// shadows the sky, mode bandwidth once more with each other visibility (bandwidth-none, -baked, -traced).
/// `reflectors`: named by the options.
std::vector<SweptTechnique> swept_techniques(const SceneFacts& facts, const Settings& settings, std::size_t reflectors,
                                             const Registry& registry = builtin_registry());

/// The mode for pictures with reflections: one without noise, so that they differ only in the reflections.
const std::string& reflection_mode(const Registry& registry = builtin_registry());
/// The reflector technique that judges the others.
const std::string& reflection_reference(const Registry& registry = builtin_registry());

/// `64 samples`, `octree.depth 8`, `default`.
std::string quality_label(const QualityStep& step);

/// One frame: `request` with the technique, the settings of the step, and in the scope estimator the restricted ones.
FrameRequest request_of(FrameRequest request, const SweptTechnique& technique, const QualityStep& step, Scope scope,
                        const Registry& registry = builtin_registry());

}  // namespace maquette::report
