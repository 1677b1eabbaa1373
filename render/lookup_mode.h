#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "render/material_store.h"
#include "scenes/environment.h"

namespace maquette {

/// Shading of a mode that takes no samples: every visible grid point by lookups in prefiltered maps, in one pass.
class LookupMode {
 public:
  virtual ~LookupMode() = default;
  /// Fits measured tables that have been loaded since the last call.
  virtual void update(MaterialStore& materials) = 0;
  /// Units 40 to 43.
  virtual void bind() const = 0;
  virtual std::size_t bytes() const = 0;
};

/// One mode's entry: its compute shader and how to make its resources for one environment.
struct LookupModeInfo {
  std::string name;
  std::string shader;
  std::function<std::unique_ptr<LookupMode>(const Environment&)> make;
};

/// The entry of a mode, or nullptr when the mode samples.
const LookupModeInfo* find_lookup_mode(const std::string& name);

}  // namespace maquette
