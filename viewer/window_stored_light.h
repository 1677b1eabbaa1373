#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/gl/objects.h"
#include "ui/inspection_state.h"
#include "viewer/window_picture.h"
#include "viewer/window_session.h"

namespace maquette {

/// What bakes have stored for the point that was clicked on: kept up to date while materials are exchanged.
class WindowStoredLight {
 public:
  void update(WindowSession* session, const WindowPicture& picture);
  void fill_facts(StoredLightFacts* facts) const;

 private:
  void describe(WindowSession* session, const WindowPicture& picture, const glm::vec2& at);

  StoredLightFacts facts_;
  std::vector<Texture> textures_, retired_;  ///< retired ones: the panels of this frame still show them
  std::optional<glm::vec2> shown_;
  std::uint64_t revision_ = 0;
  FrameRequest seen_;
};

}  // namespace maquette
