#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "render/bake/background_worker.h"
#include "render/inspection/light_on_pane.h"
#include "render/renderer.h"
#include "review/open_review.h"
#include "ui/editor_state.h"
#include "viewer/bake_lines.h"
#include "viewer/dents.h"
#include "viewer/options.h"
#include "viewer/pose.h"

namespace maquette {

/// The state of an open window: applies the edits to the renderer, reads files in the background, records the steps for
/// undo. A change that fails becomes a message and is reverted; the last valid state stays.
class WindowSession {
 public:
  /// Reads scene and environment; needs a current context. Throws Error: there is no good state yet to fall back to.
  explicit WindowSession(const SceneOptions& options);

  EditorState state;

  /// A scene, an environment or a BRDF by its extension (or a built-in name); a BRDF goes to `material`.
  void open(const std::string& source, int material);
  /// Adds the camera path of a file.
  void open_path(const std::string& source);
  /// Uses files that have been read, and applies the edits. `busy`: a control or the mouse is held.
  void update(bool busy, double now_s);
  void undo();
  void redo();
  /// What the window itself changed of the look is no step of its own.
  void amend();
  /// Widens a camera that was framed for a wider picture, once.
  void fit_camera(float aspect);
  /// Makes this the look at hand.
  void take(const Look& look);
  /// To the file of the review, or to another. A failure becomes a message.
  void save(const std::string& file);
  const OpenReview& review() const { return *review_; }
  void go_to_camera(int index);
  void frame_scene(float aspect);
  /// Elsewhere at once: a step of its own.
  void put_camera(const CameraView& camera);
  /// Requests that the exposure is computed from the picture: from the next one while nothing moves, and again until
  /// the results of all background work are visible.
  void request_metering() { metering_ = true; }
  /// `continued`: the picture is the previous one with more samples; no background result has been added to it.
  void meter_if_requested(bool continued);
  void add_message(MessageLevel level, const std::string& text);
  /// Replaces the message of its topic; with an empty text it goes.
  void set_advice(Message advice);
  void dismiss_message(int index);
  void dismiss_messages();

  /// Begins a press with the dent tool; false (and a message) when there is nothing to dent.
  bool begin_dent(const Renderer::Pick& pick);
  void drag_dent(float depth_m, float radius_m);
  void end_dent() { dragged_dent_.reset(); }
  void select(const Renderer::Pick& pick);
  /// The pane in front of the opaque surface `pick` at a point of the picture (as for pick_reflector); the surface
  /// itself where there is none, or where that pane is selected already.
  void select_in_front(const glm::vec2& at, float aspect, const Renderer::Pick& pick);
  /// Makes the pane or mirror at a point of the picture, -1 to 1 to the right and up, a reflector, or no longer one.
  /// `pick`: the opaque surface there.
  void pick_reflector(const glm::vec2& at, float aspect, const Renderer::Pick& pick);

  FrameRequest make_frame_request(int width, int height) const;
  Renderer& renderer() { return renderer_; }
  /// Grows with every change of the picture that is not part of the request.
  std::uint64_t revision() const { return revision_; }
  /// The number of these changes that replaced a material.
  std::uint64_t material_revision() const { return material_revision_; }
  /// How often a whole look has been taken.
  std::uint64_t looks_taken() const { return looks_taken_; }
  void fill_facts(EditorFacts* facts) const;
  bool loading() const { return scene_file_.valid() || environment_file_.valid() || !btf_in_work_.empty(); }
  float scene_radius() const { return bounds_.radius(); }
  const Scene& scene() const { return *scene_; }
  const Bounds& bounds() const { return bounds_; }

  /// Sources of the measured materials that the picture is drawn with.
  std::vector<std::string> drawn_sources() const;

 private:
  using ScenePointer = std::shared_ptr<Scene>;
  using EnvironmentPointer = std::shared_ptr<Environment>;
  float suggested_exposure() const;
  void use_scene(ScenePointer scene);
  void use_environment(EnvironmentPointer environment, const std::string& source);
  /// Advice goes when it is stale.
  void advise();
  void apply_ground(bool busy);
  /// The renderer has a new scene and nothing of the edits.
  void forget_applied();
  void set_camera(const CameraView& camera);
  void poll_files();
  void apply_materials();
  /// Whether a material's source can be set now; a BTF that is not in the cache is made in the background first.
  bool is_ready(const std::string& source);
  void poll_btf();
  /// Moves the nodes to where animation and turns have them.
  void apply_pose();
  /// The scene as the file has it, in which dents are pressed: they follow their part.
  std::shared_ptr<const Scene> at_rest() const;
  void apply_dents();
  void apply_visibility();
  void start_environment();
  /// Reads scene and environment again when their files have changed and rest; looks and edits stay.
  void watch_files(double now_s);
  /// `stamp`: of the source now. Once it stays as it is: it may be in work.
  bool has_changed(const std::string& source, std::uint64_t stamp);
  bool has_changed(const std::string& file);
  bool scene_has_changed(const std::string& scene);
  /// The look of a window without a review.
  void begin_look(const SceneOptions& options);
  void open_review(const std::string& file);
  Review review_now() const;
  void show(const Look& look);
  /// Look, looks and paths of a review of the present scene.
  void show(const Review& review);
  void begin_review(std::unique_ptr<OpenReview> review, const std::string& look);
  void report_notes();
  /// Whether the renderer has all that the state says.
  bool shows_state() const;
  /// Keys of the bakes of the state; nothing while they are not known.
  std::optional<BakeKeys> bake_keys_now();
  /// Says once, after a review was opened, which of its bakes are to be made, and notes the keys of kept looks when
  /// they are shown.
  void watch_bakes(bool busy);
  void tell_bakes();
  /// Keys for the file, as far as they are known.
  std::vector<ReviewBake> bakes_to_save();
  void offer_left_behind();
  void continue_review(const std::string& journal);

  Renderer renderer_;
  std::shared_ptr<Scene> scene_;  ///< with its ground, posed
  RestPose rest_;
  Bounds bounds_;
  std::shared_ptr<Environment> environment_;
  std::optional<SunPlace> sun_;  ///< without the rotation
  float suggested_ev_ = 0.0f;    ///< for an env_scale of 1
  Edits applied_;
  /// What the ground was made for.
  struct GroundOf {
    std::shared_ptr<const Environment> environment;
    std::string kind = "none";
    double height_m = 0.0, roughness = 1.0;
    bool operator==(const GroundOf&) const = default;
  };
  GroundOf ground_of_;
  float ground_rotation_deg_ = 0.0f;
  std::unique_ptr<OpenReview> review_;
  bool keeps_journal_ = true;
  std::string scene_of_file_;
  KnownBakes known_bakes_;
  std::optional<std::string> untold_bakes_;  ///< name of the look that was opened, while its bakes are not told of
  std::set<std::string> missing_;            ///< sources of the review that are not there: kept, and not applied
  std::unique_ptr<OpenReview> opening_;      ///< whose scene is being read
  std::vector<Message> messages_;
  std::vector<std::string> environment_files_, brdf_files_;
  std::future<ScenePointer> scene_file_;
  std::future<EnvironmentPointer> environment_file_;
  std::string scene_source_, environment_source_;
  bool reading_again_ = false;  ///< the scene that is open
  struct Watched {
    std::uint64_t used, seen;  ///< stamps: when it was read, and when it was looked at
  };
  std::map<std::string, Watched> watched_;
  std::vector<std::string> scene_files_;  ///< that the scene's file names
  std::string files_of_;                  ///< the scene's file
  double watched_s_ = -1e9;
  /// Makes BTFs: gives the source of each that is ready. Null until one is asked for.
  std::unique_ptr<BackgroundWorker<std::string, std::string>> btf_worker_;
  std::string btf_in_work_;  ///< empty: none
  std::set<std::string> ready_btfs_;
  std::vector<std::string> node_paths_;
  std::shared_ptr<const Scene> surfaces_of_;
  std::unique_ptr<DentedSurfaces> surfaces_;
  std::optional<std::size_t> dragged_dent_;
  bool camera_put_ = false;  ///< since the review was told
  bool metering_ = true;
  /// What the exposure was metered for: another of these is metered again.
  struct Metered {
    RestPose rest;
    std::shared_ptr<const Environment> environment;
    Edits edits;
    bool bakes_done = false;
    bool operator==(const Metered&) const = default;
  };
  Metered metered_;
  int frames_metered_ = 0;  ///< since then
  std::uint32_t seed_ = 0;
  std::uint64_t revision_ = 0, material_revision_ = 0, looks_taken_ = 0;
};

}  // namespace maquette
