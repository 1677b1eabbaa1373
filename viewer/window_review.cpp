// The review that a window works on: opening, saving, undo, looks.
#include <filesystem>

#include "scenes/error.h"
#include "scenes/suggest.h"
#include "ui/camera_control.h"
#include "viewer/window_session.h"

namespace maquette {

namespace fs = std::filesystem;

Review WindowSession::review_now() const {
  Review review;
  review.scene = absolute_source(scene_->name, fs::current_path().string());
  review.scene_of_file = scene_of_file_;
  review.look = state;
  review.looks = state.looks;
  review.paths = state.paths;
  review.regions = state.inspection.regions;
  review.inspection = state.inspection;
  return review;
}

void WindowSession::take(const Look& look) {
  show(look);
  ++looks_taken_;
}

void WindowSession::show(const Look& look) {
  const float exposure_ev = state.exposure_ev;
  static_cast<Look&>(state) = look;
  if (state.auto_exposure) state.exposure_ev = exposure_ev;
  request_metering();
}

void WindowSession::show(const Review& review) {
  show(review.look);
  state.looks = review.looks;
  state.paths = review.paths;
  state.inspection.regions = review.regions;
  static_cast<InspectionSetup&>(state.inspection) = review.inspection;
}

void WindowSession::begin_review(std::unique_ptr<OpenReview> review, const std::string& look) {
  review_ = std::move(review);
  const std::vector<std::string> missing = missing_sources(review_->review());
  missing_ = {missing.begin(), missing.end()};
  show(review_->review());
  if (!look.empty()) take(find_look(review_->review(), look));
  if (missing_.contains(state.edits.environment)) applied_.environment.clear();
  if (!missing.empty())
    add_message(MessageLevel::warning, fs::path(review_->file()).filename().string() +
                                           ": these files are missing, what they give is left out: " + join(missing));
  for (const Look& kept : review_->review().looks)
    if (const BakeKeys keys = keys_of_look(review_->bakes(), kept.name); !keys.empty()) known_bakes_.set(kept, keys);
  if (const BakeKeys keys = keys_of_look(review_->bakes(), ""); !keys.empty())
    known_bakes_.set(review_->review().look, keys);
  untold_bakes_ = look;
  report_notes();
}

void WindowSession::open_review(const std::string& file) {
  if (scene_file_.valid()) {
    add_message(MessageLevel::warning, file + ": " + scene_source_ + " is still being read; try again then");
    return;
  }
  try {
    opening_ = std::make_unique<OpenReview>(file);
    const Review& review = opening_->review();
    scene_source_ = review.scene;
    scene_file_ = std::async(std::launch::async, [source = review.scene, scene = review.scene_of_file] {
      return std::make_shared<Scene>(load_scene(source, scene));
    });
  } catch (const Error& error) {
    opening_.reset();
    add_message(MessageLevel::error, error.what());
  }
}

void WindowSession::open_path(const std::string& source) {
  try {
    CameraPath path = load_path(source);
    path.name = free_name(state.paths, path.name.empty() ? "path" : path.name);
    add_message(MessageLevel::warning, "camera path " + path.name + " added, tab Review; Space plays it");
    state.paths.push_back(std::move(path));
    state.path_view.path = static_cast<int>(state.paths.size()) - 1;
  } catch (const Error& error) {
    add_message(MessageLevel::error, error.what());
  }
}

void WindowSession::offer_left_behind() {
  const std::vector<std::string> left = OpenReview::left_behind();
  if (left.empty()) return;
  const std::string text =
      left.size() == 1 ? "An untitled review was not saved when its window closed."
                       : std::to_string(left.size()) + " untitled reviews were not saved when their windows closed.";
  messages_.push_back({MessageLevel::warning, text, true, "untitled",
                       left.size() == 1 ? "Open it again" : "Open the last one again",
                       [journal = left.front()](EditorState* editor) { editor->continued_journal = journal; }});
}

void WindowSession::continue_review(const std::string& journal) {
  if (scene_file_.valid()) return;
  try {
    opening_ = OpenReview::continued(journal);
    scene_source_ = opening_->review().scene;
    scene_file_ = std::async(std::launch::async, [source = scene_source_, scene = opening_->review().scene_of_file] {
      return std::make_shared<Scene>(load_scene(source, scene));
    });
  } catch (const Error& error) {
    opening_.reset();
    add_message(MessageLevel::error, error.what());
  }
}

void WindowSession::report_notes() {
  for (const std::string& note : review_->take_notes()) add_message(MessageLevel::warning, note);
}

void WindowSession::save(const std::string& file) {
  try {
    review_->observe(review_now(), false);
    review_->set_bakes(bakes_to_save());
    review_->save(file);
    add_message(MessageLevel::note, "saved " + file);
  } catch (const Error& error) {
    add_message(MessageLevel::error, error.what());
  }
}

void WindowSession::undo() {
  if (const std::optional<Review> before = review_->undo()) show(*before);
}

void WindowSession::redo() {
  if (const std::optional<Review> after = review_->redo()) show(*after);
}

void WindowSession::amend() {
  if (review_ && !opening_) review_->amend(review_now());
}

void WindowSession::fit_camera(float aspect) {
  const CameraView before = state.camera;
  fit_aspect(&state.camera, aspect);
  if (!(state.camera == before)) amend();
}

}  // namespace maquette
