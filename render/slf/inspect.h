#pragma once

#include <optional>
#include <string>

#include "render/bake/bake_command.h"
#include "render/slf/light_field.h"
#include "render/technique/compression_table.h"

namespace maquette {

/// Of a whole bake of incident light: its light, and the RMS that local PCA has over clusters and components, of the
/// light that leaves the scene's materials (tabulate_compression), or, without the scene that was baked, of that which
/// arrives. Nothing for other folders. Throws Error.
std::optional<BakeFigures> inspect_light_field(const std::string& folder, const Scene* scene);

/// Of the light that leaves evenly spaced texels, which is computed anew. Nothing once cancelled or where all is black.
std::optional<CompressionTable> tabulate_compression(const LightField& field, const std::atomic<bool>& cancel,
                                                     const std::function<void(double)>& progress);

}  // namespace maquette
