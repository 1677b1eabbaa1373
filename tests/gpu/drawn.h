#pragma once

#include <gtest/gtest.h>

#include "render/renderer.h"

namespace maquette {

/// One frame with all that it waits for.
struct Drawn {
  Image picture;
  FrameStats stats;
};
inline Drawn draw(Renderer* renderer, const FrameRequest& request) {
  EXPECT_TRUE(renderer->finish_background_work(request));
  Drawn drawn;
  drawn.stats = renderer->render(request);
  drawn.picture = renderer->read_radiance();
  return drawn;
}

}  // namespace maquette
