#pragma once

namespace maquette {

/// What a pass that draws panes needs to know of the reflected picture that is bound.
struct ReflectedPicture {
  bool drawn = false;
  bool has_ghost = false;       ///< a second image, mirrored by the panes' back faces
  bool low_confidence = false;  ///< there are pixels where the technique's confidence is low
};

}  // namespace maquette
