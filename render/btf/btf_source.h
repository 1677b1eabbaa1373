#pragma once

#include <memory>
#include <string>

#include "render/technique/settings.h"
#include "scenes/brdf.h"
#include "scenes/btf/btf_reading.h"

namespace maquette {

/// Whether a material's source names a BTF: a folder, a `.btf` container, a factorised `.exr`, or `builtin:btf-NAME`,
/// with `@N` behind for one of N x N texels (256).
bool is_btf_source(const std::string& source);

/// A BTF's source with what `settings` say of its reading, as `FOLDER?cosine=false&gamma=2.2`: one text is one BTF, for
/// keys, bakes and files. What is the default is left out, and so is everything of other sources.
std::string with_btf_reading(const std::string& source, const Settings& settings);

/// The two parts of such a source.
struct BtfSource {
  std::string place;
  BtfReading reading;
};
/// Throws UsageError for values out of range.
BtfSource parse_btf_source(const std::string& source);

/// Changes where the file or folder of a material's source is written anew; 0 for built-in ones.
std::uint64_t material_source_stamp(const std::string& source);

/// Loads a BTF: from the cache, or made and kept there. Throws Error. Cost: minutes for a built-in one that was never
/// made, else about a second for 256 x 256 x 81. A cache that cannot be written is reported as progress, and costs time
/// only.
std::shared_ptr<const Btf> load_btf(const std::string& source, const BtfTask& task = {});

/// The mean of a BTF over its texels and over rotations about the normal, as the table of an isotropic BRDF: what is
/// seen of it from afar. Reciprocal.
BrdfTable mean_table(const Btf& btf);

/// Changes with the content of the file or folder that a material's source names.
std::uint64_t material_source_key(const std::string& source);

/// load_brdf, and mean_table of the BTF where the source names one, from the cache when it is there.
BrdfTable load_material_table(const std::string& source, const BtfTask& task = {});

}  // namespace maquette
