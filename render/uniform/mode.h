#pragma once

#include <memory>

#include "render/shading/shading_mode.h"

namespace maquette {

/// The estimator with a fixed count of samples at every point.
std::unique_ptr<ShadingMode> make_uniform_mode();
std::vector<ShaderVariant> uniform_shader_variants();

}  // namespace maquette
