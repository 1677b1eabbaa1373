#pragma once

#include <map>
#include <string>

#include "render/gl/objects.h"

namespace maquette {

/// Which variant of a shader a plan needs; every legal one is compiled by a test.
struct ShaderVariant {
  std::string path;         ///< of a compute shader below shaders/
  std::string vertex_path;  ///< set for a graphics program; `path` is then the fragment shader
  ShaderDefines defines;
  auto operator<=>(const ShaderVariant&) const = default;
};

/// What a define holds that says yes or no.
inline std::string flag(bool on) { return on ? "1" : "0"; }

/// Compiles each variant when it is first asked for.
class ProgramCache {
 public:
  const Program& get(const ShaderVariant& variant) {
    auto found = programs_.find(variant);
    if (found == programs_.end()) {
      Program program = variant.vertex_path.empty()
                            ? Program::compute(variant.path, variant.defines)
                            : Program::graphics(variant.vertex_path, variant.path, variant.defines);
      found = programs_.emplace(variant, std::move(program)).first;
    }
    return found->second;
  }

 private:
  std::map<ShaderVariant, Program> programs_;
};


}  // namespace maquette
