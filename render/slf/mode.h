#pragma once

#include <memory>
#include <vector>

#include "render/gl/program_cache.h"
#include "render/shading/shading_mode.h"

namespace maquette {

std::unique_ptr<ShadingMode> make_light_field_mode();
std::vector<ShaderVariant> light_field_shader_variants();

}  // namespace maquette
