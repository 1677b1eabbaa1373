#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>

#include "render/renderer.h"
#include "review/look.h"
#include "viewer/pose.h"
#include "viewer/session.h"

namespace maquette {

/// All that decides a settled frame beside the look: complete bakes, nothing of earlier frames, no deadline, nothing
/// left out because an eye would not see it.
struct SettledFrame {
  FrameSize size;
  int frames = 1;  ///< averaged
};

/// Draws looks of one scene as settled frames: a picture depends on look and SettledFrame alone, never on what was
/// drawn before. Needs a current OpenGL context.
class LookStage {
 public:
  /// `scene`: as the file has it.
  explicit LookStage(std::shared_ptr<const Scene> scene) : scene_(std::move(scene)), rest_(rest_pose(*scene_)) {}

  /// Told the share of the frames that are drawn, while more than one is averaged.
  void set_progress(std::function<void(double share)> progress) { progress_ = std::move(progress); }
  /// Draws; the renderer then has the picture. Warns of bakes that are not there, on standard error. Throws Error: a
  /// file that cannot be used, a mode that cannot draw it.
  FrameStats render(const Look& look, const SettledFrame& settled);
  /// Of a bake that the look draws with, as the scene is now (Renderer::bake_key); it is not made. Throws Error.
  std::string bake_key(const Look& look, const std::string& bake);
  /// Of the last `render`.
  const Renderer& renderer() const { return *renderer_; }
  const FrameRequest& request() const { return request_; }
  const Scene& scene() const { return *drawn_; }
  /// The look's, or metered from a settled frame of 160 x 90 pixels, which replaces the picture.
  float exposure_ev(const Look& look);

 private:
  void show(const Look& look);
  void prepare(const Look& look);
  /// Moves the nodes of what is shown. False where the renderer has to be made anew.
  bool move(const Edits& edits);
  std::shared_ptr<const Environment> environment(const std::string& source);
  float suited_exposure_ev(const Look& look);

  std::shared_ptr<const Scene> scene_;
  RestPose rest_;
  std::shared_ptr<const Scene> drawn_;
  std::map<std::string, std::shared_ptr<const Environment>> environments_;
  std::unique_ptr<Renderer> renderer_;
  std::optional<Look> shown_;  ///< without what a renderer may be turned to
  PlayedAnimation animation_;  ///< as they are shown
  std::vector<NodeTurn> turns_;
  FrameRequest request_;
  std::function<void(double share)> progress_;
  std::set<std::string> told_;  ///< warnings of bakes, once each
};

}  // namespace maquette
