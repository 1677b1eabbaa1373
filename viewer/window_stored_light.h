#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "render/bake/background_worker.h"
#include "render/gl/objects.h"
#include "ui/inspection_state.h"
#include "viewer/window_picture.h"
#include "viewer/window_session.h"

namespace maquette {

/// What bakes have stored for the point that was clicked on: kept up to date while materials are exchanged.
class WindowStoredLight {
 public:
  WindowStoredLight();
  void update(WindowSession* session, const WindowPicture& picture);
  void carry_out(const InspectionActions& actions, WindowSession* session);
  void fill_facts(StoredLightFacts* facts) const;

 private:
  void update_table(WindowSession* session);
  void describe(WindowSession* session, const WindowPicture& picture, const glm::vec2& at);

  StoredLightFacts facts_;
  std::vector<Texture> textures_, retired_;  ///< retired ones: the panels of this frame still show them
  std::optional<glm::vec2> shown_;
  std::uint64_t revision_ = 0;
  FrameRequest seen_;
  BackgroundWorker<CompressionTableJob, CompressionTable> tabulator_;
  std::optional<CompressionTable> table_;
  bool can_tabulate_ = false;
  std::uint64_t tabulated_ = 0;  ///< revision of the scene that the table is of
};

}  // namespace maquette
