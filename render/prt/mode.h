#pragma once

#include <memory>
#include <vector>

#include "render/gl/program_cache.h"
#include "render/shading/shading_mode.h"

namespace maquette {

std::unique_ptr<ShadingMode> make_transfer_mode();
std::vector<ShaderVariant> transfer_shader_variants();

}  // namespace maquette
