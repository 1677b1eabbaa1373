#pragma once

#include <memory>
#include <vector>

#include "render/shading/shading_mode.h"

namespace maquette {

/// Deferred shading by predicted bandwidth: points are shaded where the picture varies, the others interpolated.
std::unique_ptr<ShadingMode> make_bandwidth_mode();
std::vector<ShaderVariant> bandwidth_shader_variants();
std::vector<DebugViewInfo> bandwidth_views();

}  // namespace maquette
