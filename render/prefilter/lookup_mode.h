#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "render/materials/material_store.h"
#include "render/shading/shading_mode.h"
#include "render/shading/work_lists.h"
#include "scenes/environment.h"

namespace maquette {

/// Prefiltered maps of one environment and fits of measured materials, for a mode that looks them up.
class LookupTables {
 public:
  virtual ~LookupTables() = default;
  /// Fits measured materials that have been loaded since the last call.
  virtual void update(MaterialStore& materials) = 0;
  /// Units 40 to 43.
  virtual void bind() const = 0;
  virtual std::size_t bytes() const = 0;
};

/// A mode that takes no samples: every visible grid point by lookups in prefiltered maps, in one pass by the compute
/// shader `shader`.
std::unique_ptr<ShadingMode> make_lookup_mode(const std::string& shader,
                                              std::function<std::unique_ptr<LookupTables>(const Environment&)> make);
std::vector<ShaderVariant> lookup_shader_variants(const std::string& shader);

/// What the techniques of such modes declare alike. `filtered`: what their maps are filtered for.
Technique lookup_technique(const std::string& name, const std::string& help, const std::string& filtered);

}  // namespace maquette
