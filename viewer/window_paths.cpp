#include "viewer/window_paths.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "review/review.h"
#include "scenes/error.h"
#include "scenes/file_name.h"

namespace maquette {

namespace {

constexpr double kFrame_s = 1.0 / 25.0;
constexpr double kTurntable_s = 12.0;
constexpr double kPathTolerance = 2e-3;  // of the scene's radius, and rad

CameraPath* chosen_path(EditorState* state) {
  const int at = state->path_view.path;
  return at >= 0 && at < static_cast<int>(state->paths.size()) ? &state->paths[static_cast<std::size_t>(at)] : nullptr;
}

bool can_play(const CameraPath& path) {
  return std::ranges::count(path.keys, false, &PathKey::skip) >= 2 && path_duration_s(path) > 0.0;
}

void keep_look(EditorState* state) {
  state->name = free_name(state->looks, "look " + std::to_string(state->looks.size() + 1));
  state->looks.push_back(canonical(*state));
}

/// What a path does not move of a look, without its name.
Look still_part(Look look) {
  look.name = look.note = "";
  look.camera = {};
  look.edits.animation = {};
  return canonical(std::move(look));
}

/// Name of the kept look that is at hand; kept now where there is none.
std::string look_at_hand(EditorState* state) {
  const Look now = still_part(*state);
  const auto same = [&](const Look& look) { return still_part(look) == now; };
  const auto named = std::ranges::find(state->looks, state->name, &Look::name);
  if (named != state->looks.end() && same(*named)) return named->name;
  const auto found = std::ranges::find_if(state->looks, same);
  if (found != state->looks.end()) return found->name;
  keep_look(state);
  return state->name;
}

/// The first key says what the path is seen in, so that it is the same from whatever is at hand later.
void add_path(EditorState* state, CameraPath path) {
  path.keys.front().look = look_at_hand(state);
  path.name = free_name(state->paths, path.name.empty() ? "path" : path.name);
  state->paths.push_back(std::move(path));
  state->path_view.path = static_cast<int>(state->paths.size()) - 1;
  state->path_view.key = 0;
  state->path_view.time_s = 0.0;
}

void add_key(EditorState* state) {
  CameraPath* path = chosen_path(state);
  PathKey key;
  key.camera = state->camera;
  if (!path) {
    CameraPath first;
    first.name = "path";
    first.keys.push_back(key);
    return add_path(state, std::move(first));
  }
  const int behind = std::clamp(state->path_view.key, -1, static_cast<int>(path->keys.size()) - 1);
  const int at = behind < 0 ? static_cast<int>(path->keys.size()) : behind + 1;
  path->keys.insert(path->keys.begin() + at, key);
  state->path_view.key = at;
}

void write_path(WindowSession* session) {
  const CameraPath* path = chosen_path(&session->state);
  if (!path) return;
  const std::string& review = session->review().file();
  const std::filesystem::path folder =
      review.empty() ? std::filesystem::current_path() : std::filesystem::path(review).parent_path();
  const std::string file = (folder / (readable_file_name(path->name) + ".path.json")).string();
  CameraPath moves = *path;  // for any scene: alone, the look of the first key is that of whoever plays it
  const auto names_look = [](const PathKey& key) { return key.look.has_value(); };
  if (std::ranges::count_if(moves.keys, names_look) == 1 && names_look(moves.keys.front()))
    moves.keys.front().look.reset();
  try {
    save_path(file, moves);
    session->add_message(MessageLevel::note, "written: " + file);
  } catch (const Error& error) {
    session->add_message(MessageLevel::error, error.what());
  }
}

void go_to_look(WindowSession* session, int index) {
  EditorState& state = session->state;
  if (index < 0 || index >= static_cast<int>(state.looks.size())) return;
  session->take(state.looks[static_cast<std::size_t>(index)]);
}

int look_beside(const EditorState& state, int step) {
  const auto count = static_cast<int>(state.looks.size());
  if (count == 0) return -1;
  const auto at = std::ranges::find(state.looks, state.name, &Look::name);
  if (at == state.looks.end()) return step > 0 ? 0 : count - 1;
  return (static_cast<int>(at - state.looks.begin()) + step + count) % count;
}

}  // namespace

void WindowPaths::carry_out(const EditorActions& actions, WindowSession* session, double now_s) {
  EditorState& state = session->state;
  PathView& view = state.path_view;
  if (actions.keep_look) keep_look(&state);
  if (actions.go_to_look >= 0) go_to_look(session, actions.go_to_look);
  if (actions.next_look != 0) go_to_look(session, look_beside(state, actions.next_look));
  if (actions.new_path) {
    CameraPath path;
    path.name = "path";
    path.keys.emplace_back().camera = state.camera;
    add_path(&state, std::move(path));
  }
  if (actions.turntable) add_path(&state, turntable(state.camera, kTurntable_s));
  if (actions.add_key) add_key(&state);
  if (actions.export_path) write_path(session);
  if (actions.record_path) {
    view.recording = !view.recording;
    begin_s_ = now_s;
    if (!view.recording) {
      const double tolerance_m = kPathTolerance * static_cast<double>(session->scene_radius());
      CameraPath path = thinned(recorded_, {tolerance_m, kPathTolerance});
      recorded_.clear();
      if (path.keys.size() >= 2)
        add_path(&state, std::move(path));
      else
        session->add_message(MessageLevel::warning, "Record: the camera has not moved");
    }
  }
  if (actions.add_animation >= 0) {
    const std::vector<Animation>& all = session->scene().animations;
    const auto at = static_cast<std::size_t>(actions.add_animation);
    if (at < all.size())
      for (CameraPath& path : paths_of_animation(session->scene(), all[at], state.camera))
        add_path(&state, std::move(path));
  }
  const CameraPath* path = chosen_path(&state);
  if (actions.play_path && path && can_play(*path)) {
    view.playing = !view.playing;
    taken_.reset();
    view.late_frames = 0;
    begin_s_ = last_frame_s_ = now_s;
  }
  if (actions.step_path != 0 && path && can_play(*path)) {
    view.playing = false;
    view.time_s = std::clamp(view.time_s + actions.step_path * kFrame_s, 0.0, path_duration_s(*path));
    view.goes_there = true;
  }
}

void WindowPaths::show_time(WindowSession* session, double time_s) {
  EditorState& state = session->state;
  const CameraPath* path = chosen_path(&state);
  if (!path || !can_play(*path)) return;
  const PathMoment moment = path_at(*path, time_s);
  // Once at each change: what is changed by hand while it plays stays.
  if (moment.look && moment.look != std::exchange(taken_, moment.look)) {
    const auto part = [&](const Look& whole) {
      Look look = still_part(whole);
      if (moment.env_rotation_deg) look.edits.env_rotation_deg = 0.0f;
      if (moment.exposure_ev) look.exposure_ev = 0.0f, look.auto_exposure = false;
      return look;
    };
    const auto look = std::ranges::find(state.looks, *moment.look, &Look::name);
    if (look != state.looks.end() && (look->name != state.name || part(*look) != part(state))) session->take(*look);
  }
  state.camera = moment.camera;
  if (!path->animation.empty()) state.edits.animation = {path->animation, moment.time_s};
  if (moment.env_rotation_deg) state.edits.env_rotation_deg = *moment.env_rotation_deg;
  if (moment.exposure_ev) {
    state.exposure_ev = *moment.exposure_ev;
    state.auto_exposure = false;
  }
  state.path_view.time_s = time_s;
}

void WindowPaths::play(WindowSession* session, double now_s) {
  PathView& view = session->state.path_view;
  const CameraPath* path = chosen_path(&session->state);
  if (!path || !can_play(*path)) {
    view.playing = false;
    return;
  }
  view.late_frames += std::max(static_cast<int>((now_s - last_frame_s_) / kFrame_s) - 1, 0);
  last_frame_s_ = now_s;
  const double elapsed_s = now_s - begin_s_;
  show_time(session, playing_time_s(*path, view.playback, elapsed_s));
  const bool ends = view.playback == Playing::once || view.playback == Playing::reverse;
  if (ends && elapsed_s >= path_duration_s(*path)) view.playing = false;
}

void WindowPaths::record(WindowSession* session, double now_s) {
  const CameraView& camera = session->state.camera;
  if (recorded_.empty()) begin_s_ = now_s;
  // Rests before the first move are no part of it.
  if (recorded_.size() == 1 && recorded_[0].camera == camera) recorded_.clear();
  recorded_.push_back({now_s - begin_s_, camera});
}

void WindowPaths::update(WindowSession* session, double now_s) {
  PathView& view = session->state.path_view;
  if (view.playing) play(session, now_s);
  playing_ = view.playing;
  if (view.recording) record(session, now_s);
  if (view.goes_there) {
    if (!view.playing) taken_.reset();
    show_time(session, view.time_s);
  }
  view.goes_there = false;
}

}  // namespace maquette
