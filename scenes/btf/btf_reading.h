#pragma once

#include <functional>
#include <string>

#include "scenes/btf/btf.h"

namespace maquette {

/// How measured values are understood where their files do not say it (docs/formats.md).
struct BtfReading {
  bool cosine = true;    ///< the light's cosine is in the values: value = pi rho cos
  double gamma = 0.0;    ///< exponent that decodes values; 0: sRGB of PNG and JPEG, 1 of the others
  double texel_m = 0.0;  ///< side of a texel; 0: what the file says, else kUnknownTexel
  int components = 8;    ///< of each view
};
/// UBO 2003: samples of about 6 cm over 256 texels.
inline constexpr double kUnknownTexel_m = 0.00025;

/// What long work reports and asks. Both may be empty.
struct BtfTask {
  std::function<void(const std::string& what, double share)> progress = {};  ///< share in [0, 1]
  std::function<bool()> cancelled = {};
  void report(const std::string& what, double share) const {
    if (progress) progress(what, share);
  }
  /// Throws Error when it is cancelled.
  void check(const std::string& where) const;
};

/// Reads a folder of images that are named by their angles, view by view: what is in memory at once are the images of
/// one view. Throws Error: no such images, missing ones (named), angles twice, mixed sizes, unreadable, not finite.
Btf read_btf_folder(const std::string& folder, const BtfReading& reading, const BtfTask& task = {});

/// Reads a `.btf` container: DFMF and BDIF; others are refused by name. Throws Error for sizes that do not fit the
/// file.
Btf read_btf_container(const std::string& path, const BtfReading& reading, const BtfTask& task = {});

/// Changes with the content of a folder or container; part of the key of what is made from it.
std::uint64_t btf_content_key(const std::string& source);

/// Angles in degrees of a file name with `tl`, `pl`, `tv`, `pv`, each followed by a number; false when one is missing.
struct BtfAngles {
  double theta_l = 0.0, phi_l = 0.0, theta_v = 0.0, phi_v = 0.0;
};
bool parse_btf_angles(const std::string& name, BtfAngles* angles);

}  // namespace maquette
