#pragma once

#include <string>
#include <vector>

#include "render/gl/objects.h"
#include "scenes/image.h"

namespace maquette {

/// A list of latitude-longitude maps of any sizes in one buffer texture, read by shaders/shared/prefiltered.glsl. The
/// first texels are records: offset of map i, its width, its height, map count. The maps' texels follow.
class PrefilteredMaps {
 public:
  /// Throws Error when the driver cannot address that many texels.
  PrefilteredMaps(const std::string& label, const std::vector<Image>& maps);
  void bind(GLuint unit) const { glBindTextureUnit(unit, view_.get()); }
  std::size_t bytes() const { return texels_.bytes(); }

 private:
  Buffer texels_;
  Texture view_;
};

/// A table with linear interpolation between its entries: 1 or 4 channels.
Texture upload_table(const std::string& label, const Image& table);

}  // namespace maquette
