#pragma once

#include <memory>
#include <string>

#include "render/reference/surface.h"
#include "scenes/btf/btf.h"

namespace maquette {

/// Why precomputed transfer cannot hold a material, or nothing.
std::string check_transfer_material(const Material& material);

/// A material as a factorised BTF: its own, or what `point` reflects (a measured table or an analytic material), sampled
/// at 81 views and 397 lights. Without a texture one texel, and at most three components, those of its colours; with one
/// of its base colour (`images`: of the scene) up to 128 x 128, and exactly two: what the base colour scales, and the
/// rest. Throws Error where the rest has a colour.
std::shared_ptr<const Btf> make_material_btf(const SurfacePoint& point, const std::vector<TextureImage>& images);

}  // namespace maquette
