#pragma once

#include <functional>

#include "render/slf/light_field.h"
#include "render/technique/settings.h"

namespace maquette {

/// What the scene and its view decide about a light field, besides settings.
struct LightFieldInput {
  std::shared_ptr<const Scene> scene;  ///< edits included, with the materials to bake with
  std::shared_ptr<const Scene> shown;  ///< the same with the materials to show
  std::shared_ptr<const FlatGeometry> geometry;
  std::shared_ptr<const Environment> environment;
  int variant = -1;
  float env_rotation_rad = 0.0f, env_scale = 1.0f;
  std::function<bool(int node)> wants = {};  ///< nodes whose parts get texels; null: all
};

/// Opaque, visible items of the wanted nodes and of those that `slf.parts` names, with what is below them.
/// `left_out`: gets a line for each material of these nodes that is not opaque.
std::vector<AtlasPart> find_light_field_parts(const LightFieldInput& input, const Settings& settings,
                                              std::vector<std::string>* left_out = nullptr);

/// The job for these settings; its folder: `folder`, or else where `slf.bake` or the cache keep it. Throws Error.
LightFieldJob make_light_field_job(const LightFieldInput& input, const Settings& settings);

LightBasis light_basis(const std::string& name);

}  // namespace maquette
