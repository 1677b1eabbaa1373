#include "viewer/window_picture.h"

#include <algorithm>
#include <cmath>

#include "scenes/error.h"
#include "scenes/ground.h"

namespace maquette {

namespace {
constexpr double kSettle_s = 0.3;  // the picture stays coarse for this time after the last move
constexpr std::size_t kHistory = 120;
constexpr double kSmoothing = 0.15;
// Edges are smoothed only when a frame takes less time than this: the first frame with four times the samples takes
// about three times as long, and cannot be interrupted.
constexpr double kQuickEnough_ms = 800.0;
/// Bakes that are done are taken over by the next frame.
constexpr double kLongestYield_ms = 1000.0;
constexpr float kFirstScale = 0.35f;  // of the first picture of another look
constexpr int kFirstSamples = 16;     // of each of its points

/// For a first picture, unless the request asks for a count.
void take_few_samples(FrameRequest* request) {
  const Technique& mode = builtin_registry().find_mode(request->mode);
  if (request->samples > 0 || mode.samples_setting.empty() || mode.can.traces_picture) return;
  request->samples = std::min(kFirstSamples, request->settings.get_int(mode.samples_setting));
}

}  // namespace

float WindowPicture::next_moving_scale(const WindowSession& session, const PictureUpdate& input,
                                       MovingScale::Kind kind) {
  const float most = session.state.still_scale;
  if (session.state.moving_scale > 0.0f) return std::min(session.state.moving_scale, most);
  if (!stats_) return most;
  return moving_scale_.next_scale(kind, static_cast<double>(input.width_px) * input.height_px, most);
}

bool WindowPicture::update(WindowSession* session, const PictureUpdate& input) {
  const int width_px = input.width_px, height_px = input.height_px;
  const double now_s = input.now_s;
  if (input.more_events && stats_ && picture_.width() == width_px && picture_.height() == height_px) return false;
  session->fit_camera(static_cast<float>(width_px) / static_cast<float>(std::max(height_px, 1)));
  const FrameRequest wanted = session->make_frame_request(width_px, height_px);
  const bool changed = !(wanted == last_wanted_) || session->revision() != last_revision_;
  // After a swap of a material the renderer keeps the accumulated results of all other materials.
  const std::uint64_t swaps = session->material_revision() - last_material_revision_;
  const bool material_only = wanted == last_wanted_ && session->revision() - last_revision_ == swaps;
  // The first frame, a new window size and a swap of a material are not moves.
  const bool moved =
      changed && !material_only && stats_ && wanted.width == last_wanted_.width && wanted.height == last_wanted_.height;
  FrameRequest rotated = last_wanted_;
  rotated.env_rotation_rad = wanted.env_rotation_rad;
  const bool rotation_only = rotated == wanted && session->revision() == last_revision_;
  last_wanted_ = wanted;
  last_revision_ = session->revision();
  last_material_revision_ = session->material_revision();
  if (changed) failed_ = false;
  if (moved || input.playing) last_change_s_ = now_s;
  // Another look is shown coarsely at once, and as it is wanted right after that. Where it has other materials alone,
  // the renderer keeps what it has of all others.
  const bool other_look = session->looks_taken() != looks_taken_ && moved && !material_only && !input.playing;
  looks_taken_ = session->looks_taken();
  const bool first_look = other_look && stats_->frame_ms > slow_look_ms_;
  if (first_look) last_change_s_ = -1e9;
  const bool moving = now_s - last_change_s_ < kSettle_s;
  // The first frame of a move has no history, and its cost is not representative.
  const bool begins = !moving_ || rotation_only != (moving_kind_ == MovingScale::Kind::light);
  if (moving && moved) {
    moving_kind_ = rotation_only ? MovingScale::Kind::light : MovingScale::Kind::other;
    last_moving_scale_ = next_moving_scale(*session, input, moving_kind_);
  }
  if (!moving) moving_scale_.rest();
  moving_ = moving;
  const float scale = first_look ? std::min(kFirstScale, session->state.still_scale)
                      : moving_  ? last_moving_scale_
                                 : session->state.still_scale;
  FrameRequest request = wanted;
  request.width = std::max(static_cast<int>(std::lround(static_cast<float>(width_px) * scale)), 1);
  request.height = std::max(static_cast<int>(std::lround(static_cast<float>(height_px) * scale)), 1);
  if (first_look) take_few_samples(&request);
  const bool background = !session->renderer().background_work().empty();
  const bool background_done = background_ && !background;
  background_ = background;
  StillEdges::Input edges;
  edges.moving_samples = wanted.msaa;
  edges.still_samples = session->state.still_msaa;
  // What a bake brings is another picture: it is shown at once, before its edges are smoothed.
  edges.changed = changed || background_done;
  edges.disturbed = moving_ || (changed && !material_only) || background_done;
  edges.may_begin = !background && !session->loading() && !session->state.error_view.open && !failed_ && stats_ &&
                    stats_->frame_ms < kQuickEnough_ms;
  edges.frames = stats_ ? stats_->accumulated_frames : 0;
  edges.now_s = now_s;
  request.msaa = still_edges_.next_samples(edges);
  const bool stale = changed || background_done || !(request == drawn_);
  // Frames that only average leave bakes the processors for as long as they took.
  const bool yields =
      background && now_s < drawn_s_ + 2e-3 * std::min(stats_ ? stats_->frame_ms : 0.0, kLongestYield_ms);
  const bool due = stale ? !failed_ : !moving_ && !input.panels_busy && !failed_ && !yields && !converged();
  const bool same_size = stats_ && request.width == drawn_.width && request.height == drawn_.height;
  if (due) drawn_s_ = now_s;
  if (due) draw(session, request, request == drawn_ && (!changed || material_only));
  if (due && !failed_ && !first_look) note_cost(moved && same_size && !begins);
  if (due && !failed_ && !moving_) session->meter_if_requested(stats_->accumulated_frames > 1);
  const EditorState& state = session->state;
  const bool better = due && !(stats_ && still_edges_.hidden(stats_->accumulated_frames));
  if (better || picture_.width() != width_px || picture_.height() != height_px || shown_tonemap_ != state.tonemap ||
      shown_exposure_ev_ != state.exposure_ev || shown_view_ != state.debug_view)
    present(session, width_px, height_px);
  return due && !failed_;
}

void WindowPicture::draw(WindowSession* session, const FrameRequest& request, bool accumulate) {
  try {
    stats_ = session->renderer().render(request, accumulate);
    drawn_ = request;
    // A request is not known to be valid while patches are being fitted: they may still be refused.
    const auto waits = [](const LeftOut& left_out) { return left_out.what == "patch_fit"; };
    if (std::ranges::none_of(stats_->plan.left_out, waits)) last_valid_ = choices_of(session->state);
    note_times();
  } catch (const Error& error) {
    if (still_edges_.smooth()) {
      still_edges_.refuse();
      drawn_.msaa = request.msaa;  // the renderer's picture is no longer the one on screen
      session->add_message(MessageLevel::note, std::string("edges stay as they are: ") + error.what());
      return;
    }
    failed_ = true;
    session->add_message(MessageLevel::error, error.what());
    if (last_valid_) restore_valid_state(session);
  }
}

WindowPicture::Choices WindowPicture::choices_of(const EditorState& state) {
  return {state.mode, state.reflections, state.settings, state.msaa, state.edits.reflectors, state.edits.part_modes};
}

/// After a mode, a setting or a set of reflectors that cannot draw this scene: restores the last valid ones, as they
/// were chosen; the request names more (parts that a setting leaves to another mode, the ground).
void WindowPicture::restore_valid_state(WindowSession* session) {
  EditorState& state = session->state;
  state.mode = last_valid_->mode;
  state.reflections = last_valid_->reflections;
  state.settings = last_valid_->settings;
  state.msaa = last_valid_->msaa;
  state.edits.reflectors = last_valid_->reflectors;
  state.edits.part_modes = last_valid_->part_modes;
  session->amend();
}

/// `move`: the frame continued a move at the size of the frame before.
void WindowPicture::note_cost(bool move) {
  const double px = static_cast<double>(drawn_.width) * drawn_.height;
  if (still_edges_.smooth()) return;  // moving frames are drawn with fewer samples
  if (move)
    moving_scale_.note(moving_kind_, stats_->frame_ms, px);
  else
    moving_scale_.note_still(stats_->frame_ms, px);
}

void WindowPicture::note_times() {
  if (history_ms_.size() >= kHistory) history_ms_.erase(history_ms_.begin());
  history_ms_.push_back(static_cast<float>(stats_->frame_ms));
  for (auto& [name, times] : pass_history_ms_) times.push_back(0.0f);  // passes that this frame skipped
  for (const PassTime& pass : stats_->passes) {
    const std::string title = stats_->plan.pass_title(pass.name, pass.layer);
    std::vector<float>& times = pass_history_ms_[title];
    if (times.empty()) times.assign(history_ms_.size(), 0.0f);
    times.back() = static_cast<float>(pass.ms);
  }
  for (auto& [name, times] : pass_history_ms_)
    if (times.size() > kHistory) times.erase(times.begin());
  std::erase_if(pass_history_ms_,
                [](const auto& pass) { return std::ranges::all_of(pass.second, [](float ms) { return ms == 0.0f; }); });
  std::vector<PassTime> next = stats_->passes;
  for (PassTime& pass : next)
    for (const PassTime& old : smooth_passes_)
      if (old.name == pass.name && old.layer == pass.layer) pass.ms = old.ms + kSmoothing * (pass.ms - old.ms);
  smooth_passes_ = std::move(next);
}

void WindowPicture::present(WindowSession* session, int width_px, int height_px) {
  if (!stats_) return;
  EditorState& state = session->state;
  if (picture_.width() != width_px || picture_.height() != height_px) {
    picture_ = Texture::make_2d("window picture", GL_RGBA8, width_px, height_px);
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    framebuffer_ = GlName<FramebufferTraits>(name);
    glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, picture_.get(), 0);
  }
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.get());
  try {
    session->renderer().present(0, 0, width_px, height_px, state.exposure_ev, state.tonemap, state.debug_view);
  } catch (const Error& error) {
    session->add_message(MessageLevel::error, error.what());
    state.debug_view.clear();
    session->renderer().present(0, 0, width_px, height_px, state.exposure_ev, state.tonemap);
  }
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  shown_tonemap_ = state.tonemap;
  shown_exposure_ev_ = state.exposure_ev;
  shown_view_ = state.debug_view;
}

void WindowPicture::blit(int x, int y) const {
  if (!framebuffer_) return;
  const int w = picture_.width(), h = picture_.height();
  glBlitNamedFramebuffer(framebuffer_.get(), 0, 0, 0, w, h, x, y, x + w, y + h, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

Renderer::Pick WindowPicture::pick(WindowSession* session, float x, float y) const {
  if (!stats_) return {};
  const auto pixel = [](float t, int count) {
    return std::clamp(static_cast<int>(t * static_cast<float>(count)), 0, count - 1);
  };
  return session->renderer().pick(pixel(x, drawn_.width), pixel(y, drawn_.height));
}

}  // namespace maquette
