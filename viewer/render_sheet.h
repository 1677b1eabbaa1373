#pragma once

#include <string>
#include <utility>
#include <vector>

#include "scenes/image.h"

namespace maquette {

struct CommandLine;

/// Pictures of equal size and channels, row by row, with a gap between them. `columns` of them a row.
Image join_pictures(const std::vector<Image>& pictures, int columns, int gap_px);

/// `maquette render --sheet`: one picture of settled frames, a column for each source of the material that is given
/// most often, a row for each environment. Throws Error.
int render_sheet(const CommandLine& line);

}  // namespace maquette
