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
  /// Defines that all shaders have in common from now on; programs with others are kept.
  void set_common(const ShaderDefines& defines) {
    common_ = defines;
    programs_ = &with_common_[defines];
  }
  const Program& get(const ShaderVariant& variant) {
    auto found = programs_->find(variant);
    if (found == programs_->end()) {
      ShaderDefines defines = common_;
      defines.insert(defines.end(), variant.defines.begin(), variant.defines.end());
      Program program = variant.vertex_path.empty() ? Program::compute(variant.path, defines)
                                                    : Program::graphics(variant.vertex_path, variant.path, defines);
      found = programs_->emplace(variant, std::move(program)).first;
    }
    return found->second;
  }

 private:
  using Programs = std::map<ShaderVariant, Program>;
  ShaderDefines common_;
  std::map<ShaderDefines, Programs> with_common_;
  Programs* programs_ = &with_common_[common_];
};

}  // namespace maquette
