#pragma once

#include <string>

#include "scenes/btf/btf.h"

namespace maquette {

/// Writes the factorised form as one multi-part OpenEXR (docs/formats.md), to a file beside that is then renamed.
/// Throws Error and leaves what was there.
void save_btf(const std::string& path, const Btf& btf);

/// Reads it back, levels made anew. Throws Error: no such file, not a factorised BTF, truncated, damaged, not finite.
Btf load_factorised_btf(const std::string& path);

/// Whether a file is an OpenEXR file that save_btf has written; false for what cannot be read.
bool is_factorised_btf(const std::string& path);

}  // namespace maquette
