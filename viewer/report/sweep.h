#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/registry.h"
#include "render/renderer.h"
#include "viewer/options.h"
#include "viewer/report/data.h"

/// What is to be measured: cameras, techniques from the registry, their quality steps.
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
  std::vector<QualityStep> steps;      ///< at least one
  std::optional<std::string> refused;  ///< why it cannot draw this scene with these settings
};
/// Every registered mode, those that cannot draw the scene with the reason.
std::vector<SweptTechnique> swept_techniques(const SceneFacts& facts, const Settings& settings);

/// `64 samples`, `octree.depth 8`, `default`.
std::string quality_label(const QualityStep& step);

/// The settings of one frame: those asked for, those of the step, and in the scope estimator the restricted ones.
Settings settings_of(const Settings& asked, const SweptTechnique& technique, const QualityStep& step, Scope scope);

}  // namespace maquette::report
