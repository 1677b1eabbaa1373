#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "render/technique/registry.h"
#include "review/look.h"

namespace maquette {

/// What the shared options of `view` and `render` say; the defaults are the program's defaults.
struct SceneOptions {
  std::set<std::string> given;  ///< names of the options that were given
  std::string review;           ///< `.maquette.json`; empty: none
  std::string look;             ///< `--look NAME` of the review; empty: the state that it was saved in
  std::string scene = "builtin:cockpit";
  std::string scene_of_file;  ///< name or index of a glTF scene; empty: the file's default
  std::string mode = builtin_registry().default_mode;
  std::string reflections = kAutoReflections;
  std::vector<std::string> reflectors;
  std::vector<PartMode> part_modes;  ///< `--mode-of NODE=MODE`
  std::string environment = "builtin:clear-sky";
  float env_rotation_deg = 0.0f;
  float env_scale = 1.0f;            ///< cd/m2 per stored unit
  std::optional<float> exposure_ev;  ///< absent: the one at which the environment looks right at once
  std::string tonemap = "pbr-neutral";
  std::vector<std::pair<std::string, std::string>> materials;  ///< material name (or `*`), source
  std::string variant;                                         ///< empty: the file's default
  std::string camera;  ///< empty: the first camera, or one that frames the scene
  std::optional<glm::vec3> eye, target, up;
  std::optional<glm::vec4> section;     ///< as Edits::section
  std::optional<float> fov_deg;         ///< vertical
  std::optional<float> orthographic_m;  ///< height of what is seen
  int width = 1280;
  int height = 720;
  int samples = 0;  ///< 0: the mode's default
  std::uint32_t seed = 0;
  int msaa = 1;
  int frames = 0;                      ///< measured frames after warm-up; 0: one, without warm-up
  std::optional<double> target_error;  ///< relative RMSE
  std::optional<double> time_s;
  std::string debug_view;  ///< `--view NAME`; empty: the picture
  std::vector<Dent> dents;
  std::vector<NodeTurn> turns;
  PlayedAnimation animation;     ///< `--animation NAME=S`; of `play` the name alone
  std::set<std::string> hidden;  ///< nodes of a review that are not shown
  Settings settings;
  std::vector<std::string> settings_given;  ///< by --set, defaults too
  std::string stats;                        ///< JSON file; empty: none
  std::string reference;                    ///< EXR file; empty: none
  std::string output;
  int average = 1;                   ///< frames of a settled picture
  std::string path;                  ///< `play`: `PATH.json`, or the name of a path of the review
  double fps = 25.0;                 ///< `play`
  std::string frame_format = "png";  ///< `play`: png or exr
  double budget_s = 600.0;           ///< `report`: the whole run
  int repeats = 3;                   ///< `report`: measurements of each point
  std::string screenshot;            ///< `view`: PNG of the window after `frames` drawn frames, then it closes
};

using ViewOptions = SceneOptions;

}  // namespace maquette
