#pragma once

#include <string>
#include <vector>

#include "render/settings.h"
#include "scenes/scene.h"

namespace maquette {

/// What the plan needs to know of a view.
struct ViewInfo {
  int width = 640;
  int height = 360;
  int msaa = 1;
  std::string reflections = "off";
  int reflectors = -1;          ///< named or marked in the scene; -1: as many as the facts count
  int reflectors_in_view = -1;  ///< of them; -1: not known, all
  bool mirrors = false;         ///< some reflector is opaque
  int glossy_in_view = -1;      ///< opaque surfaces that `octree.glossy` or a name lets mirror; -1: by the facts
};

/// Facts about the scene, counted once when it changes, so that planning a frame costs nothing.
struct SceneFacts {
  std::size_t triangle_count = 0;
  int material_count = 0;
  int measured_count = 0;
  int analytic_count = 0;
  bool has_textures = false;
  bool has_normal_maps = false;
  bool has_mask = false;
  bool has_glass = false;
  bool has_sheen = false;  ///< of materials without a table, as the next
  bool has_clearcoat = false;
  bool has_punctual_lights = false;
  bool has_emissive_meshes = false;
  bool has_subdivision = false;
  float least_roughness = 1e30f;  ///< of the opaque materials' lobes; 0: of a measured table, which may have any
  int reflector_count = 0;        ///< surfaces that the scene marks, or its panes when it marks none
  bool enclosed = false;          ///< the eye region is closed in (decides shading.visibility = auto)
};
/// Of the narrowest lobe of a material without a table; 0 where a texture may say anything.
float least_roughness(const Material& material);
SceneFacts compute_facts(const Scene& scene, int variant);

struct PlannedPass {
  std::string name;    ///< gbuffer, bandwidth, pyramid, shade, upsample, ... (docs/vocabulary.md)
  std::string reason;  ///< why it is there
};
struct LeftOut {
  std::string what;  ///< one documented vocabulary
  std::string why;
};

/// The passes and resources for this scene, camera and settings. A plain value, made without OpenGL.
struct FramePlan {
  std::string mode;
  std::string visibility;  ///< none or baked, after `auto` was decided
  std::string indirect;    ///< none or baked
  bool texture_bandwidth = false;
  bool lights = false;  ///< punctual lights or emissive meshes are sampled
  bool glass = false;
  bool sheen = false, clearcoat = false;  ///< lobes that analytic materials may have
  std::string reflections;                ///< reflector technique, or empty
  bool glossy = false;                    ///< opaque surfaces mirror too, through the octree
  int msaa = 1;
  std::vector<PlannedPass> passes;
  std::vector<LeftOut> left_out;
};

/// Throws Error when the mode cannot do what was asked (never falls back to another).
FramePlan plan(const SceneFacts& facts, const std::string& mode, const Settings& settings, const ViewInfo& view);

}  // namespace maquette
