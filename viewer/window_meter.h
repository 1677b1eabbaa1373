#pragma once

#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "render/gl/objects.h"
#include "ui/layout.h"
#include "viewer/budget_curve.h"
#include "viewer/error_meter.h"
#include "viewer/window_picture.h"
#include "viewer/window_session.h"

namespace maquette {

/// The error tab's part of the window: measures while the tab is visible and nothing moves, draws heat map and wiper,
/// computes the settings that keep a budget.
class WindowMeter {
 public:
  void update(WindowSession* session, const WindowPicture& picture, double now_s);
  void fill_facts(const WindowSession& session, MeterFacts* facts) const;
  /// Over the picture, behind the panels: between ImGui::NewFrame and Render.
  void draw_overlay(const WindowSession& session, const Rect& picture);
  /// Measures a curve of the present mode, one frame in each iteration of the window's loop, once there is a reference.
  void measure_curve() { curve_step_ = 0; }
  /// Draws the present view with each reflector technique, one in each iteration of the window's loop.
  void compare_reflectors() {
    reflector_step_ = 0;
    reflectors_.clear();
  }
  /// The renderer is busy with other pictures than the window's.
  bool comparing() const { return reflector_step_ >= 0; }
  void apply_budget(WindowSession* session) const;

 private:
  /// Also loaded by the thread that builds the scene: curves of an earlier report.
  struct Known {
    std::mutex mutex;
    BudgetCurves curves;
  };

  ErrorMeter::View view_of(const WindowSession& session, const WindowPicture& picture) const;
  void take_snapshot(WindowSession* session, std::uint64_t revision, int variant);
  void judge(WindowSession* session, const WindowPicture& picture, double now_s);
  void continue_curve(WindowSession* session, const WindowPicture& picture);
  void continue_reflectors(WindowSession* session, const WindowPicture& picture);
  std::string reference_answer() const;
  std::string what_keeps(double budget) const;
  void update_textures(const WindowSession& session);
  std::optional<BudgetCurve> find_curve(const WindowSession& session) const;

  ErrorMeter meter_;
  ErrorMeter::SceneMaker make_scene_;
  std::uint64_t snapshot_revision_ = ~std::uint64_t{0};
  std::shared_ptr<Known> known_ = std::make_shared<Known>();
  BudgetCurves measured_;
  int curve_step_ = -1;  ///< of the mode's quality steps; -1: none is being measured
  BudgetCurve curve_;
  int reflector_step_ = -1;  ///< of the registry's reflector techniques; -1: none is being measured
  std::vector<MeterFacts::Reflector> reflectors_;
  double picture_s_ = 0.0;  ///< that the picture on screen took
  std::shared_ptr<const GridReference> reference_;
  std::optional<MeteredError> error_;
  std::uint64_t version_ = 0;
  double begin_s_ = 0.0, judged_s_ = -1e9, figure_s_ = 0.0;
  int judged_frames_ = 0;
  bool moving_ = true;
  Texture heat_, truth_;
  bool textures_stale_ = true;
  std::string shown_tonemap_;
  float shown_exposure_ev_ = 0.0f;
  int picture_width_ = 1, picture_height_ = 1;
};

}  // namespace maquette
