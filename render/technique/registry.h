#pragma once

#include <string>
#include <vector>

#include "render/technique/technique.h"

namespace maquette {

/// Names that the contract knows and this version does not have yet.
struct LaterName {
  std::string name;
  std::string help;
};

/// Every technique of a program, in the order of the manual. A value: it is passed to what plans, draws, lists and
/// reports, which know techniques only by it.
struct Registry {
  std::vector<Technique> techniques;
  std::string default_mode;
  std::vector<LaterName> later_modes = {};
  std::vector<LaterName> later_settings = {};

  /// The mode of that name. Throws UsageError for an unknown name ("did you mean ...") and Error for one that arrives
  /// with a later version; `option` is what the user wrote it behind.
  const Technique& find_mode(const std::string& name, const std::string& option = "--mode") const;
  /// Reflector techniques; `off` is none of them and returns nullptr. Throws UsageError for an unknown name.
  const Technique* find_reflector(const std::string& name) const;
  std::vector<std::string> names(TechniqueKind kind) const;
  /// The first mode or reflector technique that can do something, or nullptr.
  const Technique* first_that(TechniqueKind kind, bool Capabilities::* capability) const;
  std::vector<BakeCommand> bakes() const;
  /// Throws UsageError for an unknown name ("did you mean ...") and Error for one that arrives with a later version.
  BakeCommand find_bake(const std::string& name) const;
  /// Debug views of all techniques, in their order.
  std::vector<DebugViewInfo> views() const;
};

/// The techniques of this program. Adding one is one line in registry.cpp.
const Registry& builtin_registry();

}  // namespace maquette
